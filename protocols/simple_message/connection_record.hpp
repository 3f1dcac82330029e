#pragma once

#include <chrono>
#include <string>
#include <string_view>

#include "protocols/record/connection_trace.hpp"
#include "protocols/simple_message/listener_context.hpp"

namespace aprsim::simple_message {

/// Reports the messages of one connection to tap, trace and statistics. Thread: the listener's.
class ConnectionRecord {
 public:
  ConnectionRecord(ListenerContext& context, std::string listener, std::string peer);

  /// A request that is taken now; `fault`: why it is not understood.
  void request(std::string_view bytes, std::string_view fault);
  /// A message that goes out; a reply to the latest request if `reply`.
  void sent(std::string_view bytes, bool reply);
  [[nodiscard]] const std::string& listener() const { return listener_; }
  void closed(std::string_view why) { trace_.closed(why); }

 private:
  using Clock = std::chrono::steady_clock;

  void tap(bool from_client, std::string_view bytes, std::string_view fault);

  ListenerContext& context_;
  const std::string listener_, peer_;
  protocols::ConnectionTrace trace_;
  Clock::time_point requested_at_{};
};

}  // namespace aprsim::simple_message
