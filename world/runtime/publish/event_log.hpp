#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <vector>

#include "world/api/values/cell_event.hpp"

namespace aprsim::world {

/// The latest events of a cell. One thread adds; readers copy pointers under a lock that is held
/// for nothing else.
class EventLog final : public api::EventSource {
 public:
  /// `capacity` >= 1.
  explicit EventLog(std::size_t capacity = api::kKeptEvents) : capacity_(capacity) {}

  /// Appends; their numbers follow those before. The oldest are let go. Thread: sim.
  void add(std::vector<api::CellEventPtr> events);

  [[nodiscard]] Batch after(std::uint64_t after, std::size_t most) const override;
  void wait_after(std::uint64_t after,
                  std::chrono::steady_clock::time_point deadline) const override;

 private:
  const std::size_t capacity_;
  mutable std::mutex mutex_;
  mutable std::condition_variable added_;
  std::deque<api::CellEventPtr> kept_;
};

}  // namespace aprsim::world
