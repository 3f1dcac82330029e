#include "protocols/grpc/streams/event_stream.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "protocols/messages/write_message.hpp"

namespace aprsim::grpc_server {

using std::chrono::steady_clock;

namespace {

constexpr auto kEventBeat = std::chrono::milliseconds(50);
constexpr std::size_t kEventsAtOnce = 64;  // processed with the stream locked

grpc::Status server_stops() { return {grpc::StatusCode::UNAVAILABLE, "the server is stopping"}; }

}  // namespace

EventStream::EventStream(grpc::CallbackServerContext& context, EventHub& hub,
                         const api::EventSource& events, EventWish wish)
    : BoundedStream(context),
      hub_(hub),
      events_(events),
      wish_(std::move(wish)),
      after_(wish_.after),
      until_(wish_.past_only ? events.after(0, 0).latest
                             : std::numeric_limits<std::uint64_t>::max()) {}

void EventStream::poll() { next(lock()); }

void EventStream::next(Lock lock) {
  while (!is_writing() && !is_over()) {
    if (after_ >= until_) return finish(grpc::Status::OK);
    const api::EventSource::Batch batch = events_.after(after_, kEventsAtOnce);
    if (batch.events.empty()) return;
    const std::uint64_t missing = batch.events.front()->sequence - after_ - 1;
    if (missing > 0 && !wish_.allow_gap) {
      return finish({grpc::StatusCode::OUT_OF_RANGE,
                     "after: events up to " + std::to_string(batch.oldest - 1) +
                         " are not kept any more, " + std::to_string(after_) + " was read last"});
    }
    lost_ += missing;
    for (const api::CellEventPtr& event : batch.events) {
      if (event->sequence > until_) break;
      after_ = event->sequence;
      if (!api::is_wanted(*event, wish_.kinds, wish_.names)) continue;
      response_.Clear();
      protocols::write_message(*event, *response_.mutable_event());
      response_.set_lost(std::exchange(lost_, 0));
      begin_write();
      lock.unlock();
      StartWrite(&response_);
      return;
    }
  }
}

void EventStream::OnDone() {
  hub_.remove(*this);
  self.reset();
}

EventHub::EventHub(const api::EventSource* events, int max_streams,
                   std::chrono::milliseconds write_timeout)
    : events_(events),
      max_streams_(static_cast<std::size_t>(max_streams)),
      write_timeout_(write_timeout),
      thread_([this] { run(); }) {}

EventHub::~EventHub() { stop(steady_clock::now()); }

grpc::Status EventHub::add(const std::shared_ptr<EventStream>& stream) {
  const std::lock_guard lock(mutex_);
  if (stopping_) return server_stops();
  if (streams_.size() >= max_streams_) {
    return {grpc::StatusCode::RESOURCE_EXHAUSTED,
            "all " + std::to_string(max_streams_) + " event streams are in use"};
  }
  streams_.push_back(stream);
  changed_.notify_all();
  return grpc::Status::OK;
}

void EventHub::remove(const EventStream& stream) {
  const std::lock_guard lock(mutex_);
  std::erase_if(streams_, [&](const auto& one) { return one.get() == &stream; });
  changed_.notify_all();
}

std::size_t EventHub::open() {
  const std::lock_guard lock(mutex_);
  return streams_.size();
}

void EventHub::stop(steady_clock::time_point deadline) {
  std::vector<std::shared_ptr<EventStream>> streams;
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    streams = streams_;
    changed_.notify_all();
  }
  for (const auto& stream : streams) stream->end(server_stops());
  streams.clear();
  if (thread_.joinable()) thread_.join();
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, deadline, [&] { return streams_.empty(); });
}

void EventHub::run() {
  if (events_ == nullptr) return;
  std::unique_lock lock(mutex_);
  std::uint64_t seen = 0;
  while (!stopping_) {
    if (streams_.empty()) {
      changed_.wait(lock, [this] { return stopping_ || !streams_.empty(); });
      continue;
    }
    lock.unlock();
    events_->wait_after(seen, steady_clock::now() + kEventBeat);
    seen = events_->after(0, 0).latest;
    lock.lock();
    // Never call a stream with the hub locked: its OnDone locks the hub.
    const auto streams = streams_;
    lock.unlock();
    for (const auto& stream : streams) {
      stream->poll();
      stream->cancel_if_stuck(steady_clock::now(), write_timeout_);
    }
    lock.lock();
  }
}

}  // namespace aprsim::grpc_server
