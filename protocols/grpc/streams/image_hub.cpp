#include "protocols/grpc/streams/image_hub.hpp"

#include <algorithm>
#include <string>

namespace aprsim::grpc_server {

using std::chrono::steady_clock;

namespace {

constexpr auto kImageBeat = std::chrono::milliseconds(200);

grpc::Status no_more_images() { return {grpc::StatusCode::UNAVAILABLE, "the server is stopping"}; }

}  // namespace

ImageHub::ImageHub(int max_streams, std::chrono::milliseconds write_timeout)
    : max_streams_(static_cast<std::size_t>(max_streams)),
      write_timeout_(write_timeout),
      thread_([this] { run(); }) {}

ImageHub::~ImageHub() { stop(steady_clock::now()); }

grpc::Status ImageHub::add(const std::shared_ptr<ImageStream>& stream) {
  const std::lock_guard lock(mutex_);
  if (stopping_) return no_more_images();
  if (entries_.size() >= max_streams_) {
    return {grpc::StatusCode::RESOURCE_EXHAUSTED,
            "all " + std::to_string(max_streams_) + " image streams are in use"};
  }
  entries_.push_back({stream, steady_clock::now()});
  changed_.notify_all();
  return grpc::Status::OK;
}

void ImageHub::remove(const ImageStream& stream) {
  const std::lock_guard lock(mutex_);
  std::erase_if(entries_, [&](const Entry& entry) { return entry.stream.get() == &stream; });
  changed_.notify_all();
}

std::size_t ImageHub::open() {
  const std::lock_guard lock(mutex_);
  return entries_.size();
}

void ImageHub::stop(steady_clock::time_point deadline) {
  std::vector<Entry> entries;
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    entries = entries_;
    changed_.notify_all();
  }
  for (const Entry& entry : entries) entry.stream->end(no_more_images());
  entries.clear();
  if (thread_.joinable()) thread_.join();
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, deadline, [&] { return entries_.empty(); });
}

ImageHub::Time ImageHub::collect_due(Time now, std::vector<std::shared_ptr<ImageStream>>& due) {
  Time next = now + kImageBeat;
  for (Entry& entry : entries_) {
    if (entry.due <= now) {
      due.push_back(entry.stream);
      entry.due += entry.stream->period();
      if (entry.due <= now) entry.due = now + entry.stream->period();
    }
    next = std::min(next, entry.due);
  }
  return next;
}

void ImageHub::run() {
  std::vector<std::shared_ptr<ImageStream>> due, all;
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    if (entries_.empty()) {
      changed_.wait(lock, [this] { return stopping_ || !entries_.empty(); });
      continue;
    }
    const Time now = steady_clock::now(), next = collect_due(now, due);
    for (const Entry& entry : entries_) all.push_back(entry.stream);
    // Never call a stream with the hub locked: its OnDone locks the hub.
    lock.unlock();
    for (const auto& stream : due) stream->take();
    for (const auto& stream : all) stream->cancel_if_stuck(now, write_timeout_);
    due.clear();
    all.clear();
    lock.lock();
    if (!stopping_) changed_.wait_until(lock, next);
  }
}

}  // namespace aprsim::grpc_server
