#include "protocols/grpc/streams/image_stream.hpp"

#include <algorithm>
#include <utility>

#include "protocols/grpc/calls/rpc_status.hpp"
#include "protocols/grpc/streams/image_message.hpp"

namespace aprsim::grpc_server {

using std::chrono::steady_clock;

namespace {

constexpr auto kImageBeat = std::chrono::milliseconds(200);

grpc::Status no_more_images() { return {grpc::StatusCode::UNAVAILABLE, "the server is stopping"}; }

}  // namespace

ImageStream::ImageStream(grpc::CallbackServerContext& context, ImageHub& hub,
                         protocols::CameraPictures& pictures, ImageWish wish)
    : context_(context),
      hub_(hub),
      pictures_(pictures),
      wish_(std::move(wish)),
      period_(static_cast<std::int64_t>(1e9 / wish_.rate_hz)) {}

void ImageStream::take() { take(Lock(mutex_)); }

void ImageStream::take(Lock lock) {
  if (finished_ || ending_ || taking_) return;
  if (writing_) {
    // Before the call has begun nothing is lost.
    if (write_started_ == steady_clock::time_point{}) return;
    ++sequence_;
    ++dropped_;
    due_ = true;
    return;
  }
  taking_ = true;
  lock.unlock();
  pictures_.take_picture(wish_.camera, wish_.form,
                         [stream = shared_from_this()](Result<protocols::CameraPicture> picture) {
                           stream->send(std::move(picture));
                         });
}

void ImageStream::send(Result<protocols::CameraPicture> picture) {
  Lock lock(mutex_);
  taking_ = false;
  if (finished_) return;
  if (ending_) return finish(end_status_);
  if (!picture) return finish(rpc_status(picture.error()));
  writing_ = true;
  write_started_ = steady_clock::now();
  v1::StreamImagesResponse head;
  head.set_sequence(++sequence_);
  head.set_dropped_count(dropped_);
  lock.unlock();
  response_ = image_message(head.SerializeAsString(), v1::StreamImagesResponse::kImageFieldNumber,
                            wish_.name, wish_.format, *picture);
  StartWrite(&response_);
}

void ImageStream::cancel_if_stuck(steady_clock::time_point now,
                                  std::chrono::milliseconds write_timeout) {
  const std::lock_guard lock(mutex_);
  if (finished_ || !writing_ || write_started_ == steady_clock::time_point{} ||
      now - write_started_ < write_timeout) {
    return;
  }
  context_.TryCancel();
}

void ImageStream::finish(const grpc::Status& status) {
  finished_ = true;
  Finish(status);
}

void ImageStream::end(const grpc::Status& status) {
  const std::lock_guard lock(mutex_);
  if (finished_ || ending_) return;
  ending_ = true;
  end_status_ = status;
  // A message may be stuck; the beginning of the call is through in a moment.
  if (!writing_) return finish(end_status_);
  if (write_started_ != steady_clock::time_point{}) context_.TryCancel();
}

void ImageStream::OnSendInitialMetadataDone(bool ok) { OnWriteDone(ok); }

void ImageStream::OnWriteDone(bool ok) {
  Lock lock(mutex_);
  writing_ = false;
  if (!ok || ending_) return finish(ending_ ? end_status_ : grpc::Status::CANCELLED);
  if (std::exchange(due_, false)) take(std::move(lock));
}

void ImageStream::OnCancel() { end(grpc::Status::CANCELLED); }

void ImageStream::OnDone() {
  hub_.remove(*this);
  self.reset();
}

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
