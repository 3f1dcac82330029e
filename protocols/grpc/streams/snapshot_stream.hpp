#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <string>

#include <grpcpp/server_context.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>

#include "aprsim/v1/telemetry_service.pb.h"
#include "protocols/grpc/streams/shared_view.hpp"
#include "world/api/snapshot/snapshot.hpp"

namespace aprsim::grpc_server {

class StreamHub;

/// Largest backlog of a stream of every step.
struct BacklogLimits {
  std::size_t samples = 4096;
  std::size_t bytes = std::size_t{8} << 20;
};

/// One client's stream of snapshots, with at most one write in flight. A stream at a rate keeps one
/// more sample; a newer one replaces it and counts it as dropped, so a slow reader costs constant
/// memory and always receives the latest. A stream of every step queues the serialized samples up
/// to a limit, beyond which the call ends.
class SnapshotStream final : public grpc::ServerWriteReactor<grpc::ByteBuffer> {
 public:
  /// `rate_hz` 0 = every step.
  SnapshotStream(grpc::CallbackServerContext& context, StreamHub& hub,
                 std::shared_ptr<SharedView> view, double rate_hz, BacklogLimits limits);

  /// Offers a sample to a stream at a rate. Thread: the hub's.
  void produce(const api::SnapshotPtr& snapshot);
  /// Appends the next sample to a stream of every step; `max_bytes` limits the backlog as well.
  /// Thread: the hub's for steps.
  void append(const api::SnapshotPtr& snapshot, std::size_t max_bytes);
  /// Cancels the call if one write has been in flight for longer than that. Thread: the hub's.
  void cancel_if_stuck(std::chrono::steady_clock::time_point now,
                       std::chrono::milliseconds write_timeout);
  /// Ends the call with the status, at once if no write is in flight, else by cancelling it.
  void end(const grpc::Status& status);
  /// Ends the call with the status after the write in flight; drops the backlog.
  void give_up(const grpc::Status& status);

  [[nodiscard]] bool every_step() const { return rate_hz_ == 0; }
  /// Between two samples at a rate.
  [[nodiscard]] std::chrono::nanoseconds period() const { return period_; }

  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

  /// Owned by the call: set right after construction, released in OnDone.
  std::shared_ptr<SnapshotStream> self;

 private:
  struct Sample {
    api::SnapshotPtr snapshot;
    std::uint64_t sequence = 0;
  };
  struct Encoded {
    grpc::Slice snapshot;
    std::uint64_t sequence = 0;
  };
  void start_write(std::unique_lock<std::mutex> lock, Sample sample);
  void start_write(std::unique_lock<std::mutex> lock);
  void fill(const grpc::Slice& snapshot, std::uint64_t sequence, std::uint64_t dropped);
  void finish(std::unique_lock<std::mutex> lock);

  grpc::CallbackServerContext& context_;
  StreamHub& hub_;
  const std::shared_ptr<SharedView> view_;
  const double rate_hz_;
  const std::chrono::nanoseconds period_;
  const BacklogLimits limits_;

  grpc::ByteBuffer response_;  // touched only by whoever has set writing_

  std::mutex mutex_;
  bool writing_ = false;
  bool finished_ = false;  // Finish was called: the context may be gone at any moment
  bool ending_ = false;
  grpc::Status end_status_;
  Sample waiting_;               // at a rate
  std::deque<Encoded> backlog_;  // of every step
  std::size_t backlog_bytes_ = 0;
  std::uint64_t sequence_ = 0;
  std::uint64_t dropped_ = 0;
  std::chrono::steady_clock::time_point write_started_;
};

}  // namespace aprsim::grpc_server
