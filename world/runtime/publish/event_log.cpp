#include "world/runtime/publish/event_log.hpp"

#include <algorithm>
#include <utility>

namespace aprsim::world {
namespace {

/// Copied while the simulation may have to wait for it.
constexpr std::size_t kMostAtOnce = 256;

}  // namespace

void EventLog::add(std::vector<api::CellEventPtr> events) {
  if (events.empty()) return;
  std::vector<api::CellEventPtr> old;  // let go outside the lock
  {
    const std::lock_guard lock(mutex_);
    for (auto& event : events) kept_.push_back(std::move(event));
    while (kept_.size() > capacity_) {
      old.push_back(std::move(kept_.front()));
      kept_.pop_front();
    }
  }
  added_.notify_all();
}

EventLog::Batch EventLog::after(std::uint64_t after, std::size_t most) const {
  Batch batch;
  const std::size_t limit = std::min(most, kMostAtOnce);
  batch.events.reserve(limit);
  const std::lock_guard lock(mutex_);
  if (kept_.empty()) return batch;
  batch.oldest = kept_.front()->sequence;
  batch.latest = kept_.back()->sequence;
  const std::uint64_t skipped = after < batch.oldest ? 0 : after - batch.oldest + 1;
  for (std::uint64_t i = skipped; i < kept_.size() && batch.events.size() < limit; ++i) {
    batch.events.push_back(kept_[i]);
  }
  return batch;
}

void EventLog::wait_after(std::uint64_t after,
                          std::chrono::steady_clock::time_point deadline) const {
  std::unique_lock lock(mutex_);
  added_.wait_until(lock, deadline,
                    [&] { return !kept_.empty() && kept_.back()->sequence > after; });
}

}  // namespace aprsim::world
