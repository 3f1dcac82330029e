#include "protocols/grpc/streams/stream_hub.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "protocols/grpc/streams/snapshot_stream.hpp"

namespace aprsim::grpc_server {

using std::chrono::steady_clock;

namespace {
constexpr auto kBeat = std::chrono::milliseconds(200), kStepBeat = std::chrono::milliseconds(50);
/// Largest queue of the thread for steps, in snapshots.
constexpr std::size_t kMostWaiting = 1024, kLeastWaiting = 16;

/// As many as take so many bytes, approximately.
std::size_t places_for(const api::Snapshot& snapshot, std::size_t max_bytes) {
  const std::size_t bytes = sizeof snapshot + snapshot.robots.size() * sizeof(api::RobotSnapshot) +
                            snapshot.bodies.size() * sizeof(api::BodySnapshot) +
                            snapshot.contacts.capacity() * sizeof(api::ContactSnapshot);
  return std::clamp(max_bytes / bytes, kLeastWaiting, kMostWaiting);
}

/// A step that has not been published, or a change of a paused cell.
bool is_news(const api::Snapshot& now, const api::Snapshot* before) {
  return before == nullptr || now.step != before->step || now.epoch != before->epoch ||
         now.paused || before->paused;
}
}  // namespace

StreamHub::StreamHub(const api::SnapshotSource& source, api::SnapshotFeed* feed, int max_streams,
                     std::size_t max_backlogs_bytes, std::chrono::milliseconds write_timeout,
                     std::function<void()> on_beat)
    : source_(source),
      feed_(feed),
      max_streams_(static_cast<std::size_t>(max_streams)),
      max_backlogs_bytes_(max_backlogs_bytes),
      write_timeout_(write_timeout),
      on_beat_(std::move(on_beat)),
      thread_([this] { run(); }),
      step_thread_([this] { run_steps(); }) {}

StreamHub::~StreamHub() { stop(steady_clock::now()); }

grpc::Status StreamHub::add(const std::shared_ptr<SnapshotStream>& stream) {
  const std::lock_guard lock(mutex_);
  if (stopping_) return {grpc::StatusCode::UNAVAILABLE, "the server is stopping"};
  if (stream->every_step() && feed_ == nullptr) {
    return {grpc::StatusCode::UNIMPLEMENTED, "every_step: there is no stream of every step here"};
  }
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
  if (step_thread_.joinable()) step_thread_.join();
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, deadline, [&] { return entries_.empty(); });
}

StreamHub::Time StreamHub::collect_due(Time now,
                                       std::vector<std::shared_ptr<SnapshotStream>>& due) {
  Time next = now + kBeat;
  for (auto& entry : entries_) {
    if (entry.stream->every_step()) continue;
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

std::vector<std::shared_ptr<SnapshotStream>> StreamHub::step_streams() const {
  std::vector<std::shared_ptr<SnapshotStream>> out;
  for (const auto& entry : entries_) {
    if (entry.stream->every_step()) out.push_back(entry.stream);
  }
  return out;
}

void StreamHub::run_steps() {
  if (feed_ == nullptr) return;
  std::shared_ptr<api::SnapshotFollower> follower;
  std::vector<api::SnapshotPtr> snapshots;
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    // The cell is followed only while there are such streams.
    if (step_streams().empty()) {
      follower.reset();
      last_step_.reset();
      changed_.wait(lock, [this] { return stopping_ || !step_streams().empty(); });
      continue;
    }
    lock.unlock();
    if (!follower) follower = feed_->follow(places_for(*source_.latest(), max_backlogs_bytes_ / 2));
    const bool complete = follower->take(snapshots, steady_clock::now() + kStepBeat);
    hand_out(snapshots, complete);
    snapshots.clear();
    lock.lock();
  }
}

void StreamHub::hand_out(const std::vector<api::SnapshotPtr>& snapshots, bool complete) {
  std::vector<std::shared_ptr<SnapshotStream>> streams;
  {
    const std::lock_guard lock(mutex_);
    streams = step_streams();
  }
  const std::size_t part = max_backlogs_bytes_ / 2 / std::max<std::size_t>(streams.size(), 1);
  for (const api::SnapshotPtr& snapshot : snapshots) {
    if (!is_news(*snapshot, last_step_.get())) continue;
    last_step_ = snapshot;
    for (const auto& stream : streams) stream->append(snapshot, part);
  }
  if (complete) return;
  for (const auto& stream : streams) {
    stream->give_up({grpc::StatusCode::RESOURCE_EXHAUSTED,
                     "the cell takes its steps faster than they can be sent; ask for fewer fields "
                     "or a lower speed"});
  }
}

}  // namespace aprsim::grpc_server
