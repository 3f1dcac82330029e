#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <vector>

#include "world/api/values/cell_event.hpp"
#include "world/runtime/publish/event_ring.hpp"

namespace aprsim::world {

/// The latest events of a cell, in memory that is allocated once. One thread adds; readers copy at
/// most 256 events under a lock that is held for nothing else.
class EventLog final : public api::EventSource {
 public:
  /// Keeps `capacity` events, at least 1, of 256 bytes on average.
  explicit EventLog(std::size_t capacity = api::kKeptEvents);

  /// Appends events whose numbers follow those before; the oldest ones are dropped. Thread: sim.
  void add(std::vector<api::CellEventPtr> events);

  [[nodiscard]] Batch after(std::uint64_t after, std::size_t most) const override;
  void wait_after(std::uint64_t after,
                  std::chrono::steady_clock::time_point deadline) const override;
  [[nodiscard]] std::size_t memory() const override;

 private:
  mutable std::mutex mutex_;
  mutable std::condition_variable added_;
  EventRing kept_;
};

}  // namespace aprsim::world
