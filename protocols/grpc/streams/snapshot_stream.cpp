#include "protocols/grpc/streams/snapshot_stream.hpp"

#include <array>
#include <utility>

#include <google/protobuf/io/coded_stream.h>

#include "protocols/grpc/streams/stream_hub.hpp"

namespace aprsim::grpc_server {

using std::chrono::steady_clock;

namespace {

/// Tag of a field that holds a message.
constexpr std::uint8_t kSnapshotTag = v1::StreamSnapshotsResponse::kSnapshotFieldNumber << 3 | 2;

std::chrono::nanoseconds period_of(double rate_hz) {
  return std::chrono::nanoseconds(rate_hz > 0 ? static_cast<std::int64_t>(1e9 / rate_hz) : 0);
}

}  // namespace

SnapshotStream::SnapshotStream(grpc::CallbackServerContext& context, StreamHub& hub,
                               std::shared_ptr<SharedView> view, double rate_hz,
                               BacklogLimits limits)
    : context_(context),
      hub_(hub),
      view_(std::move(view)),
      rate_hz_(rate_hz),
      period_(period_of(rate_hz)),
      limits_(limits) {}

void SnapshotStream::produce(const api::SnapshotPtr& snapshot) {
  std::unique_lock lock(mutex_);
  if (finished_ || ending_) return;
  Sample sample{snapshot, ++sequence_};
  if (writing_) {
    if (waiting_.snapshot) {
      ++dropped_;
      ++hub_.counters().dropped;
    }
    waiting_ = std::move(sample);
    return;
  }
  start_write(std::move(lock), std::move(sample));
}

void SnapshotStream::append(const api::SnapshotPtr& snapshot, std::size_t max_bytes) {
  grpc::Slice encoded = view_->encode(snapshot);
  std::unique_lock lock(mutex_);
  if (finished_ || ending_) return;
  const bool full = backlog_bytes_ + encoded.size() > std::min(limits_.bytes, max_bytes);
  if (backlog_.size() >= limits_.samples || full) {
    hub_.counters().dropped += backlog_.size() + 1;
    const std::string status = "the reader is " + std::to_string(backlog_.size()) + " steps and " +
                               std::to_string(backlog_bytes_) +
                               " bytes behind, more than the server keeps";
    lock.unlock();
    return give_up({grpc::StatusCode::RESOURCE_EXHAUSTED, status});
  }
  backlog_bytes_ += encoded.size();
  backlog_.push_back({std::move(encoded), ++sequence_});
  if (!writing_) start_write(std::move(lock));
}

void SnapshotStream::cancel_if_stuck(steady_clock::time_point now,
                                     std::chrono::milliseconds write_timeout) {
  const std::lock_guard lock(mutex_);
  if (finished_ || !writing_ || now - write_started_ < write_timeout) return;
  context_.TryCancel();
}

void SnapshotStream::end(const grpc::Status& status) {
  const std::lock_guard lock(mutex_);
  if (finished_) return;
  if (writing_) context_.TryCancel();
  if (ending_) return;
  ending_ = true;
  end_status_ = status;
  if (writing_) return;
  finished_ = true;
  Finish(end_status_);
}

void SnapshotStream::give_up(const grpc::Status& status) {
  std::unique_lock lock(mutex_);
  if (finished_ || ending_) return;
  ending_ = true;
  end_status_ = status;
  backlog_.clear();
  backlog_bytes_ = 0;
  if (!writing_) finish(std::move(lock));
}

void SnapshotStream::finish(std::unique_lock<std::mutex> lock) {
  finished_ = true;
  const grpc::Status status = ending_ ? end_status_ : grpc::Status::CANCELLED;
  Finish(status);
  lock.unlock();
}

void SnapshotStream::start_write(std::unique_lock<std::mutex> lock, Sample sample) {
  writing_ = true;
  write_started_ = steady_clock::now();
  const std::uint64_t dropped = dropped_;
  lock.unlock();
  fill(view_->encode(sample.snapshot), sample.sequence, dropped);
  ++hub_.counters().samples;
  StartWrite(&response_);
}

void SnapshotStream::start_write(std::unique_lock<std::mutex> lock) {
  writing_ = true;
  write_started_ = steady_clock::now();
  const Encoded next = std::move(backlog_.front());
  backlog_.pop_front();
  backlog_bytes_ -= next.snapshot.size();
  const bool more = !backlog_.empty();
  lock.unlock();
  fill(next.snapshot, next.sequence, 0);
  ++hub_.counters().samples;
  // The next message may go with it.
  grpc::WriteOptions options;
  if (more) options.set_buffer_hint();
  StartWrite(&response_, options);
}

/// The message as protobuf would write it, with the snapshot's bytes shared.
void SnapshotStream::fill(const grpc::Slice& snapshot, std::uint64_t sequence,
                          std::uint64_t dropped) {
  v1::StreamSnapshotsResponse head;
  head.set_sequence(sequence);
  head.set_dropped_count(dropped);
  head.set_effective_rate_hz(rate_hz_);
  std::string bytes = head.SerializeAsString();
  bytes += static_cast<char>(kSnapshotTag);
  std::array<std::uint8_t, 5> length{};
  std::uint8_t* end = google::protobuf::io::CodedOutputStream::WriteVarint32ToArray(
      static_cast<std::uint32_t>(snapshot.size()), length.data());
  bytes.append(length.data(), end);
  const std::array<grpc::Slice, 2> slices{grpc::Slice(bytes), snapshot};
  response_ = grpc::ByteBuffer(slices.data(), slices.size());
}

void SnapshotStream::OnWriteDone(bool ok) {
  std::unique_lock lock(mutex_);
  writing_ = false;
  if (!ok || ending_) return finish(std::move(lock));
  if (waiting_.snapshot) return start_write(std::move(lock), std::exchange(waiting_, {}));
  if (!backlog_.empty()) start_write(std::move(lock));
}

void SnapshotStream::OnCancel() { end(grpc::Status::CANCELLED); }

void SnapshotStream::OnDone() {
  hub_.remove(*this);
  self.reset();
}

}  // namespace aprsim::grpc_server
