#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "world/api/snapshot/snapshot.hpp"

namespace aprsim::world {

/// Holds the latest snapshot. Readers copy a pointer under a lock that is held for nothing else,
/// and a snapshot returns to a pool when its last reader releases it, so that publishing does not
/// grow the heap.
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
  [[nodiscard]] api::SnapshotPtr wait_for_step(
      const api::SnapshotPtr& seen, std::uint64_t step,
      std::chrono::steady_clock::time_point deadline) const;

 private:
  /// Outlives the slot while a reader still holds one of its snapshots.
  class Pool {
   public:
    std::unique_ptr<api::Snapshot> acquire() {
      const std::lock_guard lock(mutex_);
      if (free_.empty()) return std::make_unique<api::Snapshot>();
      auto snapshot = std::move(free_.back());
      free_.pop_back();
      return snapshot;
    }
    void release(std::unique_ptr<api::Snapshot> snapshot) {
      const std::lock_guard lock(mutex_);
      if (free_.size() < kMaxFree) free_.push_back(std::move(snapshot));
    }

   private:
    static constexpr std::size_t kMaxFree = 16;
    std::mutex mutex_;
    std::vector<std::unique_ptr<api::Snapshot>> free_;
  };
  std::shared_ptr<Pool> pool_;
  mutable std::mutex mutex_;
  mutable std::condition_variable published_;
  api::SnapshotPtr latest_;
  mutable unsigned waiting_for_any_ = 0;  ///< snapshot
  mutable unsigned waiting_for_step_ = 0;
  mutable std::uint64_t first_step_ = 0;  ///< lower bound of the steps that readers wait for
};

inline SnapshotSlot::SnapshotSlot()
    : pool_(std::make_shared<Pool>()), latest_(std::make_shared<const api::Snapshot>()) {}

inline std::unique_ptr<api::Snapshot> SnapshotSlot::acquire() { return pool_->acquire(); }

inline void SnapshotSlot::publish(std::unique_ptr<api::Snapshot> snapshot) {
  api::SnapshotPtr next(snapshot.release(), [pool = pool_](const api::Snapshot* done) {
    pool->release(std::unique_ptr<api::Snapshot>(const_cast<api::Snapshot*>(done)));
  });
  bool wakes = false;
  {
    const std::lock_guard lock(mutex_);
    latest_.swap(next);
    // Waking a thread can cost as much as a step.
    wakes = waiting_for_any_ > 0 || (waiting_for_step_ > 0 && (latest_->step >= first_step_ ||
                                                               latest_->epoch != next->epoch ||
                                                               !latest_->world_fault.empty()));
  }
  if (wakes) published_.notify_all();
  // `next`, the previous snapshot, is released here, outside the lock.
}

inline api::SnapshotPtr SnapshotSlot::latest() const {
  const std::lock_guard lock(mutex_);
  return latest_;
}

inline api::SnapshotPtr SnapshotSlot::wait_newer(
    const api::SnapshotPtr& seen, std::chrono::steady_clock::time_point deadline) const {
  std::unique_lock lock(mutex_);
  ++waiting_for_any_;
  published_.wait_until(lock, deadline, [&] { return latest_ != seen; });
  --waiting_for_any_;
  return latest_;
}

inline api::SnapshotPtr SnapshotSlot::wait_for_step(
    const api::SnapshotPtr& seen, std::uint64_t step,
    std::chrono::steady_clock::time_point deadline) const {
  std::unique_lock lock(mutex_);
  first_step_ = waiting_for_step_++ == 0 ? step : std::min(first_step_, step);
  published_.wait_until(lock, deadline, [&] {
    return latest_ != seen && (latest_->step >= step || latest_->epoch != seen->epoch ||
                               !latest_->world_fault.empty());
  });
  --waiting_for_step_;
  return latest_;
}

}  // namespace aprsim::world
