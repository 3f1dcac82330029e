#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <list>
#include <mutex>
#include <optional>
#include <thread>

#include <grpcpp/server_context.h>
#include <grpcpp/support/server_callback.h>

#include "world/api/ports/ports.hpp"

namespace aprsim::grpc_server {

/// Finishes unary calls once a snapshot shows that their command has taken effect, from its own
/// thread: gRPC's threads never wait.
class CommandWaiter {
 public:
  /// Checks a snapshot: nullopt = not yet; else the status to finish with. Fills the response.
  using Outcome = std::function<std::optional<grpc::Status>(const api::Snapshot&)>;
  struct Call {
    grpc::CallbackServerContext* context = nullptr;
    std::function<void(const grpc::Status&)> finish;  ///< the call's reactor
    std::chrono::steady_clock::time_point deadline;
    Outcome outcome;
    std::function<void()> on_giving_up;  ///< when cancelled or too late; may be empty
    std::uint64_t from_step = 0;         ///< earlier snapshots of this epoch need no check
    /// Fills the response and finishes the call with OK at its deadline; empty = it fails then.
    std::function<void(const api::Snapshot&)> confirm = {};
  };

  explicit CommandWaiter(const api::SnapshotSource& source);
  ~CommandWaiter();

  /// Takes the call over; it is finished exactly once, at the latest at its deadline.
  void wait(Call call);
  /// Finishes all calls with UNAVAILABLE, also later ones.
  void stop();

 private:
  void run();
  [[nodiscard]] static bool finish_if_over(Call& call, const api::Snapshot& snapshot);

  const api::SnapshotSource& source_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::list<Call> calls_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace aprsim::grpc_server
