#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>

#include <boost/asio/io_context.hpp>

#include "modbus/request_validator.hpp"
#include "protocols/modbus/banks/register_bank.hpp"
#include "protocols/modbus/modbus_server.hpp"
#include "protocols/modbus/reply_builder.hpp"
#include "protocols/modbus/security/handshake_pace.hpp"
#include "protocols/net/limited_log.hpp"
#include "world/base/duration_histogram.hpp"

namespace aprsim::modbus_server {

class Connection;

struct Counters {
  std::atomic<std::uint64_t> dropped{0}, requests{0}, exceptions{0};
  api::DurationHistogram answer_times;  ///< from a request to its reply
};

/// Everything that the connections of a port share. Thread: the listener's.
struct ListenerContext {
  boost::asio::io_context& io;
  const ModbusServerOptions& options;
  RegisterBank& bank;
  ReplyBuilder& replies;
  protocols::LimitedLog& log;
  Counters& counters;
  HandshakePace& handshakes;  ///< of ports with TLS
  modbus::RequestRules rules;
  const api::SnapshotSource& source;  ///< of injected faults
  /// Calls poll_applied() of this connection every millisecond or so until it returns false.
  std::function<void(std::shared_ptr<Connection>)> await_applied;
  std::function<void(Connection&)> closed;
};

}  // namespace aprsim::modbus_server
