#pragma once

#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "protocols/modbus/listener_context.hpp"
#include "protocols/record/connection_trace.hpp"

namespace aprsim::modbus_server {

/// Reports the messages of one connection to tap, trace and statistics. Thread: the listener's.
class ConnectionRecord {
 public:
  ConnectionRecord(ListenerContext& context, std::string peer);

  /// Bytes of one message from the stream; `fault` is the reason why they are no request.
  void received(std::span<const std::uint8_t> adu, std::string_view fault);
  /// Identity of the client's certificate, for the messages from now on.
  void identify(std::string identity) { identity_ = std::move(identity); }
  /// They are a request that is executed now, or refused for this reason.
  void request(std::span<const std::uint8_t> adu, const std::string& refusal);
  /// The reply to the latest request. It counts as a poll if its request does.
  void reply(std::span<const std::uint8_t> adu);
  /// Whole messages, one after the other.
  void sent(std::span<const std::uint8_t> adus);
  void closed(std::string_view why) { trace_.closed(why); }

 private:
  using Clock = std::chrono::steady_clock;

  void tap(bool from_client, std::span<const std::uint8_t> adu, const std::string& refusal = {});

  ListenerContext& context_;
  const std::string peer_;
  std::string identity_;
  protocols::ConnectionTrace trace_;
  Clock::time_point received_at_{};  // the latest request
};

}  // namespace aprsim::modbus_server
