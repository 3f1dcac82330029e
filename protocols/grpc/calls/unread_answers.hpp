#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include <grpcpp/support/server_interceptor.h>

#include "protocols/net/limited_log.hpp"

namespace aprsim::grpc_server {

/// Bounds the messages that gRPC holds because their clients do not read them: HTTP/2's flow
/// control lets a client keep any number of answers at the server. Beyond the limit the calls whose
/// messages have waited longest are cancelled, which is logged. Thread: any.
class UnreadAnswers {
 public:
  using Clock = std::chrono::steady_clock;

  /// Memory of an open call besides its messages, as measured; counted with each message.
  static constexpr std::size_t kCallBytes = std::size_t{32} << 10;

  /// `max_bytes`: of all these messages and their calls together; `timeout`: longest wait of one.
  UnreadAnswers(std::size_t max_bytes, std::chrono::milliseconds timeout)
      : max_bytes_(max_bytes), timeout_(timeout) {}

  /// For ServerBuilder::experimental().SetInterceptorCreators(), before all others: their objects
  /// must outlive its own. It outlives the server. Counts the calls whose method `counts` names.
  [[nodiscard]] std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> interceptor(
      std::function<bool(std::string_view method)> counts);

  /// Cancels the calls whose message has waited for the timeout.
  void cancel_stuck(Clock::time_point now);
  /// Size of all messages of calls that are not cancelled, and of these calls.
  [[nodiscard]] std::size_t bytes() const;

  // For the interceptor.
  /// `cancel` cancels the call and works until remove() with the returned number. `peer`, for the
  /// log: the identifier of gRPC.
  [[nodiscard]] std::uint64_t add(std::function<void()> cancel, std::string peer,
                                  std::size_t bytes);
  /// Has no effect on 0 or a second time.
  void remove(std::uint64_t number);

 private:
  struct Message {
    std::function<void()> cancel;
    std::string peer;
    std::size_t bytes = 0;
    Clock::time_point since;
    bool cancelled = false;
  };
  void give_up(Message& message, const std::string& why);

  const std::size_t max_bytes_;
  const std::chrono::milliseconds timeout_;
  mutable std::mutex mutex_;                   // of all below
  std::map<std::uint64_t, Message> messages_;  // the oldest first
  std::size_t bytes_ = 0;
  std::uint64_t last_number_ = 0;
  protocols::LimitedLog log_{"grpc"};
};

}  // namespace aprsim::grpc_server
