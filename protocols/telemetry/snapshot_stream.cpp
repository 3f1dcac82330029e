#include "protocols/telemetry/snapshot_stream.hpp"

#include <utility>

#include "protocols/messages/write_message.hpp"
#include "protocols/telemetry/stream_hub.hpp"

namespace aprsim::telemetry {

using std::chrono::steady_clock;

SnapshotStream::SnapshotStream(grpc::CallbackServerContext& context, StreamHub& hub,
                               std::string instance_id, double rate_hz, SnapshotMask mask)
    : context_(context),
      hub_(hub),
      instance_id_(std::move(instance_id)),
      rate_hz_(rate_hz),
      period_(static_cast<std::int64_t>(1e9 / rate_hz)),
      mask_(std::move(mask)) {}

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

void SnapshotStream::cancel_if_stuck(steady_clock::time_point now,
                                     std::chrono::milliseconds write_timeout) {
  const std::lock_guard lock(mutex_);
  if (finished_ || !writing_ || now - write_started_ < write_timeout) return;
  context_.TryCancel();
}

void SnapshotStream::end(const grpc::Status& status) {
  const std::lock_guard lock(mutex_);
  if (finished_ || ending_) return;
  ending_ = true;
  end_status_ = status;
  if (writing_) {
    context_.TryCancel();
    return;
  }
  finished_ = true;
  Finish(end_status_);
}

void SnapshotStream::start_write(std::unique_lock<std::mutex> lock, Sample sample) {
  writing_ = true;
  write_started_ = steady_clock::now();
  const std::uint64_t dropped = dropped_;
  lock.unlock();
  fill(sample, dropped);
  ++hub_.counters().samples;
  StartWrite(&response_);
}

void SnapshotStream::fill(const Sample& sample, std::uint64_t dropped) {
  response_.Clear();
  response_.set_sequence(sample.sequence);
  response_.set_dropped_count(dropped);
  response_.set_effective_rate_hz(rate_hz_);
  protocols::write_message(*sample.snapshot, instance_id_, *response_.mutable_snapshot());
  mask_.trim(*response_.mutable_snapshot());
}

void SnapshotStream::OnWriteDone(bool ok) {
  std::unique_lock lock(mutex_);
  writing_ = false;
  if (!ok || ending_) {
    finished_ = true;
    Finish(ending_ ? end_status_ : grpc::Status::CANCELLED);
    return;
  }
  if (waiting_.snapshot) start_write(std::move(lock), std::exchange(waiting_, {}));
}

void SnapshotStream::OnCancel() { end(grpc::Status::CANCELLED); }

void SnapshotStream::OnDone() {
  hub_.remove(*this);
  self.reset();
}

}  // namespace aprsim::telemetry
