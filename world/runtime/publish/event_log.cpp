#include "world/runtime/publish/event_log.hpp"

#include <algorithm>
#include <memory>
#include <string>
#include <string_view>

namespace aprsim::world {
namespace {

/// Events copied under the lock at once; the simulation may wait for that.
constexpr std::size_t kMostAtOnce = 256;
/// Memory of an event on average, and of the smallest log.
constexpr std::size_t kEventBytes = 256, kLeastBytes = std::size_t{64} << 10;

}  // namespace

EventLog::EventLog(std::size_t capacity)
    : kept_(capacity, std::max(kLeastBytes, capacity * kEventBytes)) {}

void EventLog::add(std::vector<api::CellEventPtr> events) {
  if (events.empty()) return;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& event : events) kept_.push(*event);
  }
  added_.notify_all();
}

EventLog::Batch EventLog::after(std::uint64_t after, std::size_t most) const {
  Batch batch;
  const std::size_t limit = std::min(most, kMostAtOnce);
  std::string bytes;
  std::vector<std::size_t> sizes;
  sizes.reserve(limit);
  bytes.reserve(limit * kEventBytes);
  {
    const std::lock_guard lock(mutex_);
    if (kept_.size() == 0) return batch;
    batch.oldest = kept_.sequence(0);
    batch.latest = kept_.sequence(kept_.size() - 1);
    const std::uint64_t skipped = after < batch.oldest ? 0 : after - batch.oldest + 1;
    for (std::uint64_t i = skipped; i < kept_.size() && sizes.size() < limit; ++i) {
      const std::string_view event = kept_.bytes(i);
      bytes.append(event);
      sizes.push_back(event.size());
    }
  }
  batch.events.reserve(sizes.size());
  std::string_view rest = bytes;
  for (const std::size_t size : sizes) {
    batch.events.push_back(
        std::make_shared<const api::CellEvent>(EventRing::decode(rest.substr(0, size))));
    rest.remove_prefix(size);
  }
  return batch;
}

void EventLog::wait_after(std::uint64_t after,
                          std::chrono::steady_clock::time_point deadline) const {
  std::unique_lock lock(mutex_);
  added_.wait_until(lock, deadline,
                    [&] { return kept_.size() > 0 && kept_.sequence(kept_.size() - 1) > after; });
}

std::size_t EventLog::memory() const {
  const std::lock_guard lock(mutex_);
  return kept_.memory();
}

}  // namespace aprsim::world
