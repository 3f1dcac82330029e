#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "protocols/modbus/listener_context.hpp"

namespace aprsim::modbus_server {

/// Executes the requests of one connection, one after the other. A write waits until a snapshot
/// contains it. Thread: the listener's.
class RequestExecutor {
 public:
  using Clock = std::chrono::steady_clock;
  using Reply = std::vector<std::uint8_t>;  ///< one whole message (ADU)

  RequestExecutor(ListenerContext& context, std::string peer)
      : context_(context), peer_(std::move(peer)) {}

  /// The reply; absent = the request is a write that waits for the simulation.
  [[nodiscard]] std::optional<Reply> execute(const modbus::ValidatedRequest& validated);
  /// Replies with an exception, which is counted and recorded.
  [[nodiscard]] Reply refuse(std::span<const std::uint8_t> adu, modbus::ExceptionCode code);

  [[nodiscard]] bool waiting() const { return waiting_.has_value(); }
  /// The reply to the pending write, once it has been applied or has timed out.
  [[nodiscard]] std::optional<Reply> poll(Clock::time_point now);
  /// A stop waits behind the pending write: it times out as early as a stop does.
  void hurry();
  /// Drops the pending write.
  void cancel() { waiting_.reset(); }

 private:
  struct WaitingWrite {
    api::Ticket ticket = 0;
    Clock::time_point since, deadline;
    std::vector<std::uint8_t> adu;
    bool stop = false;  ///< is confirmed at the deadline
  };

  [[nodiscard]] std::optional<Reply> write(const modbus::ValidatedRequest& validated);
  [[nodiscard]] Reply answer(std::span<const std::uint8_t> adu);

  ListenerContext& context_;
  const std::string peer_;
  std::optional<WaitingWrite> waiting_;
};

}  // namespace aprsim::modbus_server
