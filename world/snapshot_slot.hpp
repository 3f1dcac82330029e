#pragma once

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>

#include "world/api/snapshot.hpp"

namespace aprsim::world {

/// Holds the latest snapshot. Readers copy a pointer under a lock that is held for nothing else,
/// and a snapshot that its last reader lets go returns to a pool, so that publishing does not grow
/// the heap.
class SnapshotSlot {
 public:
  SnapshotSlot();

  /// A snapshot to fill, with the capacity of an earlier one where there is one. Thread: sim.
  [[nodiscard]] std::unique_ptr<api::Snapshot> acquire();
  /// Thread: sim.
  void publish(std::unique_ptr<api::Snapshot> snapshot);

  /// Thread: any.
  [[nodiscard]] api::SnapshotPtr latest() const;
  [[nodiscard]] api::SnapshotPtr wait_newer(const api::SnapshotPtr& seen,
                                            std::chrono::steady_clock::time_point deadline) const;

 private:
  class Pool;
  std::shared_ptr<Pool> pool_;
  mutable std::mutex mutex_;
  mutable std::condition_variable published_;
  api::SnapshotPtr latest_;
};

}  // namespace aprsim::world
