#include "world/snapshot_slot.hpp"

#include <utility>
#include <vector>

namespace aprsim::world {

/// Outlives the slot while a reader still holds one of its snapshots.
class SnapshotSlot::Pool {
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

SnapshotSlot::SnapshotSlot()
    : pool_(std::make_shared<Pool>()), latest_(std::make_shared<const api::Snapshot>()) {}

std::unique_ptr<api::Snapshot> SnapshotSlot::acquire() { return pool_->acquire(); }

void SnapshotSlot::publish(std::unique_ptr<api::Snapshot> snapshot) {
  api::SnapshotPtr next(snapshot.release(), [pool = pool_](const api::Snapshot* done) {
    pool->release(std::unique_ptr<api::Snapshot>(const_cast<api::Snapshot*>(done)));
  });
  {
    const std::lock_guard lock(mutex_);
    latest_.swap(next);
  }
  published_.notify_all();
  // `next`, the former latest, is let go here, outside the lock.
}

api::SnapshotPtr SnapshotSlot::latest() const {
  const std::lock_guard lock(mutex_);
  return latest_;
}

api::SnapshotPtr SnapshotSlot::wait_newer(const api::SnapshotPtr& seen,
                                          std::chrono::steady_clock::time_point deadline) const {
  std::unique_lock lock(mutex_);
  published_.wait_until(lock, deadline, [&] { return latest_ != seen; });
  return latest_;
}

}  // namespace aprsim::world
