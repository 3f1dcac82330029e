#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "world/api/snapshot/snapshot.hpp"

/// Every snapshot in its order, for readers that must not miss one.
namespace aprsim::api {

/// Collects the snapshots that are published between two queries, up to a bound. The publisher
/// never waits for longer than it takes to copy a pointer.
class SnapshotFollower {
 public:
  explicit SnapshotFollower(std::size_t capacity) : capacity_(capacity) {}

  /// Thread: the publisher's.
  void offer(const SnapshotPtr& snapshot) {
    {
      const std::lock_guard lock(mutex_);
      if (waiting_.size() >= capacity_) {
        lost_ = true;
        return;
      }
      waiting_.push_back(snapshot);
    }
    offered_.notify_one();
  }

  /// Waits until there is something, or until the deadline, and puts it into `out`, which should be
  /// empty. False: some have been lost since the last time, after what is in `out`.
  [[nodiscard]] bool take(std::vector<SnapshotPtr>& out,
                          std::chrono::steady_clock::time_point deadline) {
    std::unique_lock lock(mutex_);
    offered_.wait_until(lock, deadline, [this] { return !waiting_.empty() || lost_; });
    out.swap(waiting_);
    return !std::exchange(lost_, false);
  }

 private:
  const std::size_t capacity_;
  std::mutex mutex_;
  std::condition_variable offered_;
  std::vector<SnapshotPtr> waiting_;
  bool lost_ = false;
};

/// Where they come from.
class SnapshotFeed {
 public:
  virtual ~SnapshotFeed() = default;
  /// From the next snapshot on, until the follower is let go. `capacity`: how many may wait to be
  /// taken. Thread: any.
  [[nodiscard]] virtual std::shared_ptr<SnapshotFollower> follow(std::size_t capacity) = 0;
};

/// The followers of a publisher; without any, publishing costs one test of a flag.
class SnapshotFollowers final : public SnapshotFeed {
 public:
  [[nodiscard]] std::shared_ptr<SnapshotFollower> follow(std::size_t capacity) override {
    auto follower = std::make_shared<SnapshotFollower>(capacity);
    const std::lock_guard lock(mutex_);
    all_.push_back(follower);
    any_ = true;
    return follower;
  }

  /// Thread: the publisher's.
  void publish(const SnapshotPtr& snapshot) {
    if (!any_.load(std::memory_order_relaxed)) return;
    const std::lock_guard lock(mutex_);
    std::erase_if(all_, [&](const std::weak_ptr<SnapshotFollower>& weak) {
      const auto follower = weak.lock();
      if (follower) follower->offer(snapshot);
      return !follower;
    });
    any_ = !all_.empty();
  }

 private:
  std::atomic<bool> any_{false};
  std::mutex mutex_;
  std::vector<std::weak_ptr<SnapshotFollower>> all_;
};

}  // namespace aprsim::api
