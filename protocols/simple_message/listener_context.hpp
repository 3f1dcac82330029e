#pragma once

#include <atomic>
#include <cstdint>
#include <span>

#include <boost/asio/io_context.hpp>

#include "protocols/net/limited_log.hpp"
#include "protocols/simple_message/codec/request_framer.hpp"
#include "protocols/simple_message/simple_message_server.hpp"
#include "world/base/duration_histogram.hpp"

namespace aprsim::simple_message {

class Connection;

/// The three ports of a robot.
enum class Role : std::uint8_t { kMotion, kState, kGripper };

/// Counters of all connections together, for any thread to read.
struct Counters {
  std::atomic<std::uint64_t> dropped{0}, requests{0}, rejected{0}, skipped{0};
  api::DurationHistogram answer_times;
};

/// The side of the server that connections call. Thread: the listener's.
class ConnectionOwner {
 public:
  virtual ~ConnectionOwner() = default;
  /// A complete request. False: it cannot be taken now, and is offered again later.
  [[nodiscard]] virtual bool take(Connection& connection, std::span<const std::uint8_t> request,
                                  bool known_length) = 0;
  /// Whether a reply is still owed to it.
  [[nodiscard]] virtual bool owes(const Connection& connection) const = 0;
  /// It has closed.
  virtual void ended(Connection& connection) = 0;
  /// All of its messages have been sent.
  virtual void written(Connection& connection) = 0;
  /// Virtual time has come to the instant that a connection has asked for.
  virtual void time_passed() = 0;
};

/// Everything that the connections of one robot share. Thread: the listener's.
struct ListenerContext {
  boost::asio::io_context& io;
  const SimpleMessageOptions& options;
  const api::SnapshotSource& source;
  protocols::LimitedLog& log;
  Counters& counters;
  ConnectionOwner& owner;
  ByteOrder order = ByteOrder::kBig;
};

}  // namespace aprsim::simple_message
