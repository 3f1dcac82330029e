#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <span>
#include <vector>

#include "world/api/commands/command.hpp"
#include "world/base/result.hpp"

namespace aprsim::world {

struct QueuedCommand {
  api::Ticket ticket = 0;
  api::Command command;
};

/// Bounded queue from any thread to the simulation thread. The lock is held for a push or a swap of
/// two vectors, never across I/O. A stop (api::is_stop) is accepted even when the queue is
/// full; equal stops are merged then. Each endpoint has extra room, a sixteenth of
/// the capacity, which no other endpoint can fill. At most 4 slow commands (resets, saves, loads,
/// changes of the scene) may wait at once.
class CommandQueue {
 public:
  explicit CommandQueue(std::size_t capacity);

  /// Numbers and queues a command; kUnavailable when closed, or full and it is no stop. Thread:
  /// any.
  [[nodiscard]] Result<api::Ticket> push(api::Command command);

  /// Moves everything queued into `out`, which is cleared first. Thread: sim.
  void drain(std::vector<QueuedCommand>& out);

  /// Waiting commands. Thread: any.
  [[nodiscard]] std::size_t size() const;
  [[nodiscard]] std::size_t capacity() const { return capacity_; }

  /// Whether a command of any other endpoint waits. Thread: sim.
  [[nodiscard]] bool holds_other_than(std::span<const api::EndpointId> endpoints);

  /// Counts pushes and calls of notify(). Thread: any.
  [[nodiscard]] std::uint64_t changes();
  /// Ends a wait_until(). Thread: any.
  void notify();
  /// Waits until changes() differs from `seen`, the deadline passes or the queue is closed.
  /// Thread: sim.
  void wait_until(std::uint64_t seen, std::chrono::steady_clock::time_point deadline);

  /// Refuses all later commands and ends a wait. Thread: any.
  void close();

 private:
  struct Share {
    api::EndpointId endpoint = 0;
    std::size_t waiting = 0;
  };

  /// Drops the stops that `stop` supersedes, and adopts their belt settings.
  void merge_stops(api::Command& stop);
  [[nodiscard]] Share& share_of(api::EndpointId endpoint);
  /// Extra room of each endpoint.
  [[nodiscard]] std::size_t own_places() const;
  [[nodiscard]] std::size_t room() const;

  const std::size_t capacity_;
  mutable std::mutex mutex_;
  std::condition_variable filled_;
  std::vector<QueuedCommand> queue_;
  std::vector<Share> shares_;
  api::Ticket last_ticket_ = 0;
  std::uint64_t changes_ = 0;
  bool closed_ = false;
};

}  // namespace aprsim::world
