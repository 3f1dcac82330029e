#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include <grpcpp/server_context.h>
#include <grpcpp/support/server_callback.h>

#include "aprsim/v1/telemetry_service.pb.h"
#include "protocols/telemetry/field_mask.hpp"
#include "world/api/snapshot.hpp"

namespace aprsim::telemetry {

class StreamHub;

/// One client's stream of snapshots: at most one write in flight and one sample waiting behind it.
/// A newer sample replaces the waiting one, which then counts as dropped, so a slow reader costs
/// constant memory and always gets the latest.
class SnapshotStream final : public grpc::ServerWriteReactor<v1::StreamSnapshotsResponse> {
 public:
  SnapshotStream(grpc::CallbackServerContext& context, StreamHub& hub, std::string instance_id,
                 double rate_hz, SnapshotMask mask);

  /// Offers a sample. Thread: the hub's.
  void produce(const api::SnapshotPtr& snapshot);
  /// Cancels the call if one write has been in flight for longer than that. Thread: the hub's.
  void cancel_if_stuck(std::chrono::steady_clock::time_point now,
                       std::chrono::milliseconds write_timeout);
  /// Ends the call with the status, at once if no write is in flight, else by cancelling it.
  void end(const grpc::Status& status);

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
  void fill(const Sample& sample, std::uint64_t dropped);
  void start_write(std::unique_lock<std::mutex> lock, Sample sample);

  grpc::CallbackServerContext& context_;
  StreamHub& hub_;
  const std::string instance_id_;
  const double rate_hz_;
  const std::chrono::nanoseconds period_;
  const SnapshotMask mask_;

  v1::StreamSnapshotsResponse response_;  // touched only by whoever has set writing_

  std::mutex mutex_;
  bool writing_ = false;
  bool finished_ = false;  // Finish was called: the context may be gone at any moment
  bool ending_ = false;
  grpc::Status end_status_;
  Sample waiting_;
  std::uint64_t sequence_ = 0;
  std::uint64_t dropped_ = 0;
  std::chrono::steady_clock::time_point write_started_;
};

}  // namespace aprsim::telemetry
