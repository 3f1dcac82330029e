#include "server/journal/record_queue.hpp"

#include <algorithm>
#include <new>
#include <utility>

namespace aprsim::server::journal {
namespace {

/// Of an entry without what hangs on it, and of a saved state while it waits.
constexpr std::size_t kEntryBytes = 512;

}  // namespace

void Missing::add(const Missing& more) {
  if (!more.any()) return;
  begin = any() ? std::min(begin, more.begin) : more.begin;
  end = std::max(end, more.end);
  records += more.records;
  commands += more.commands;
  if (reason.empty()) reason = more.reason;
}

std::size_t Entry::bytes() const {
  std::size_t sum = kEntryBytes;
  if (const auto* sampled = std::get_if<StateSampled>(&what)) {
    sum += sizeof(double) * (sampled->sample.joints_rad.size() + sampled->sample.bodies_m.size());
  }
  if (const auto* saved = std::get_if<StateSaved>(&what)) {
    sum += static_cast<std::size_t>(saved->state->bytes());
  }
  return sum;
}

bool RecordQueue::push(Entry entry) {
  const std::size_t bytes = entry.bytes();
  {
    const std::lock_guard lock(mutex_);
    if (!missing_.any() && bytes_ + bytes <= max_bytes_) {
      try {
        entries_.push_back(std::move(entry));
        bytes_ += bytes;
        filled_.notify_one();
        return true;
      } catch (const std::bad_alloc&) {
        // As if there were no room.
      }
    }
    const std::uint64_t commands = std::holds_alternative<CommandApplied>(entry.what) ? 1 : 0;
    missing_.add({1, commands, entry.wall, entry.wall, {}});
  }
  filled_.notify_one();
  return false;
}

void RecordQueue::take(Taken& taken, std::chrono::steady_clock::time_point deadline) {
  taken.entries.clear();
  std::unique_lock lock(mutex_);
  filled_.wait_until(lock, deadline,
                     [this] { return closed_ || !entries_.empty() || missing_.any(); });
  taken.entries.swap(entries_);
  taken.missing = std::exchange(missing_, {});
  bytes_ = 0;
}

void RecordQueue::close() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }
  filled_.notify_all();
}

}  // namespace aprsim::server::journal
