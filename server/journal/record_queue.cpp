#include "server/journal/record_queue.hpp"

#include <algorithm>
#include <new>
#include <utility>

namespace aprsim::server::journal {
namespace {

/// Memory of an entry without its heap data.
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
  if (const auto* wire = std::get_if<protocols::WireRecord>(&what)) {
    sum += wire->data.capacity() + wire->method.capacity() + wire->text.capacity();
  }
  if (const auto* refused = std::get_if<Refused>(&what)) {
    sum += refused->listener.capacity() + refused->what.capacity();
  }
  return sum;
}

Missing Entry::missing(std::string reason) const {
  const bool decides =
      std::holds_alternative<CommandApplied>(what) || std::holds_alternative<EpochBegun>(what);
  return {1, decides ? 1U : 0U, wall, wall, std::move(reason)};
}

RecordQueue::Pushed RecordQueue::push(Entry entry) {
  const std::size_t bytes = entry.bytes();
  const std::lock_guard lock(mutex_);
  if (!missing_.any() && bytes_ + bytes <= max_bytes_) {
    try {
      entries_.push_back(std::move(entry));
      const bool pressed = 2 * bytes_ >= max_bytes_;
      bytes_ += bytes;
      return !pressed && 2 * bytes_ >= max_bytes_ ? Pushed::kPressing : Pushed::kTaken;
    } catch (const std::bad_alloc&) {
      // Counts as no room.
    }
  }
  missing_.add(entry.missing());
  return Pushed::kMissing;
}

void RecordQueue::lose(const Missing& missing) {
  const std::lock_guard lock(mutex_);
  missing_.add(missing);
}

std::size_t RecordQueue::bytes() const {
  const std::lock_guard lock(mutex_);
  return bytes_;
}

void RecordQueue::take(Taken& taken) {
  taken.entries.clear();
  const std::lock_guard lock(mutex_);
  taken.entries.swap(entries_);
  taken.missing = std::exchange(missing_, {});
  bytes_ = 0;
}

}  // namespace aprsim::server::journal
