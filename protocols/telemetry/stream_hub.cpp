#include "protocols/telemetry/stream_hub.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "protocols/telemetry/snapshot_stream.hpp"

namespace aprsim::telemetry {

using std::chrono::steady_clock;

namespace {
constexpr auto kBeat = std::chrono::milliseconds(200);
}

StreamHub::StreamHub(const api::SnapshotSource& source, int max_streams,
                     std::chrono::milliseconds write_timeout, std::function<void()> on_beat)
    : source_(source),
      max_streams_(static_cast<std::size_t>(max_streams)),
      write_timeout_(write_timeout),
      on_beat_(std::move(on_beat)),
      thread_([this] { run(); }) {}

StreamHub::~StreamHub() { stop(steady_clock::now()); }

grpc::Status StreamHub::add(const std::shared_ptr<SnapshotStream>& stream) {
  const std::lock_guard lock(mutex_);
  if (stopping_) return {grpc::StatusCode::UNAVAILABLE, "the server is stopping"};
  if (entries_.size() >= max_streams_) {
    return {grpc::StatusCode::RESOURCE_EXHAUSTED,
            "all " + std::to_string(max_streams_) + " snapshot streams are in use"};
  }
  entries_.push_back({stream, steady_clock::now()});
  changed_.notify_all();
  return grpc::Status::OK;
}

void StreamHub::remove(const SnapshotStream& stream) {
  const std::lock_guard lock(mutex_);
  std::erase_if(entries_, [&](const Entry& entry) { return entry.stream.get() == &stream; });
  changed_.notify_all();
}

std::size_t StreamHub::open() {
  const std::lock_guard lock(mutex_);
  return entries_.size();
}

void StreamHub::stop(steady_clock::time_point deadline) {
  std::vector<Entry> entries;
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    entries = entries_;
    changed_.notify_all();
  }
  for (const auto& entry : entries) {
    entry.stream->end({grpc::StatusCode::UNAVAILABLE, "the server is stopping"});
  }
  entries.clear();
  if (thread_.joinable()) thread_.join();
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, deadline, [&] { return entries_.empty(); });
}

StreamHub::Time StreamHub::collect_due(Time now,
                                       std::vector<std::shared_ptr<SnapshotStream>>& due) {
  Time next = now + kBeat;
  for (auto& entry : entries_) {
    if (entry.due <= now) {
      due.push_back(entry.stream);
      entry.due += entry.stream->period();
      if (entry.due <= now) entry.due = now + entry.stream->period();
    }
    next = std::min(next, entry.due);
  }
  return next;
}

void StreamHub::run() {
  std::vector<std::shared_ptr<SnapshotStream>> due, all;
  Time next_beat = steady_clock::now();
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    const Time now = steady_clock::now();
    const bool beat = now >= next_beat;
    const Time next = std::min(collect_due(now, due), next_beat);
    if (beat) {
      for (const auto& entry : entries_) all.push_back(entry.stream);
    }
    if (!due.empty() || beat) {
      // Never call a stream with the hub locked: its OnDone locks the hub.
      lock.unlock();
      const api::SnapshotPtr snapshot = source_.latest();
      for (const auto& stream : due) stream->produce(snapshot);
      for (const auto& stream : all) stream->cancel_if_stuck(now, write_timeout_);
      if (beat) {
        on_beat_();
        next_beat = now + kBeat;
      }
      due.clear();
      all.clear();
      lock.lock();
      continue;
    }
    changed_.wait_until(lock, next);
  }
}

}  // namespace aprsim::telemetry
