#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <grpcpp/server_context.h>
#include <grpcpp/support/server_callback.h>

#include "aprsim/v1/trajectory_service.pb.h"
#include "world/api/ports/ports.hpp"

namespace aprsim::grpc_server {

class TrajectoryHub;

/// A goal that has been submitted.
struct SubmittedGoal {
  api::Ticket ticket = 0;  ///< also the number of the stream
  int robot = 0;
  std::vector<std::size_t> joints;  ///< of the robot, in the goal's order
  SimTime feedback_period{};        ///< 0 = no feedback
  /// Stops the robot's motion by this goal. Thread: any.
  std::function<void()> cancel;
};

/// One client's goal: acceptance, feedback and result, with at most one write in flight. A slow
/// reader misses feedback, never the result. The end of the call in mid-motion cancels the goal.
class TrajectoryStream final : public grpc::ServerWriteReactor<v1::FollowJointTrajectoryResponse> {
 public:
  TrajectoryStream(grpc::CallbackServerContext& context, TrajectoryHub& hub,
                   const api::SnapshotSource& source, SubmittedGoal goal);

  /// Sends the initial metadata. Call it first.
  void begin() { StartSendInitialMetadata(); }
  /// Sends what a snapshot has for the goal, if nothing is in flight. Thread: the hub's.
  void look(const api::Snapshot& snapshot);
  /// Cancels the call if one write has been in flight for longer than that. Thread: the hub's.
  void cancel_if_stuck(std::chrono::steady_clock::time_point now,
                       std::chrono::milliseconds write_timeout);
  /// Cancels the goal and ends the call with the status, at once if no write is in flight.
  void end(const grpc::Status& status);

  void OnSendInitialMetadataDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

  /// Owned by the call: set right after construction, released in OnDone.
  std::shared_ptr<TrajectoryStream> self;

 private:
  using Lock = std::unique_lock<std::mutex>;
  void look(const api::Snapshot& snapshot, Lock lock);
  void await_acceptance(const api::Snapshot& snapshot, Lock lock);
  void write(Lock lock);
  void write_feedback(const api::Snapshot& snapshot, const api::RobotSnapshot& robot, Lock lock);
  void finish(const grpc::Status& status);

  grpc::CallbackServerContext& context_;
  TrajectoryHub& hub_;
  const api::SnapshotSource& source_;
  const SubmittedGoal goal_;

  v1::FollowJointTrajectoryResponse response_;
  std::mutex mutex_;
  bool writing_ = true;  // until the call has begun
  bool accepted_ = false, over_ = false, finished_ = false, ending_ = false;
  grpc::Status end_status_;
  SimTime next_feedback_{};
  std::chrono::steady_clock::time_point write_started_;
};

/// The goals under way, looked at by a thread with every snapshot.
class TrajectoryHub {
 public:
  TrajectoryHub(const api::SnapshotSource& source, std::chrono::milliseconds write_timeout);
  ~TrajectoryHub();

  /// Not OK: RESOURCE_EXHAUSTED with too many goals, UNAVAILABLE once stopped.
  [[nodiscard]] grpc::Status add(const std::shared_ptr<TrajectoryStream>& stream);
  void remove(const TrajectoryStream& stream);
  /// Cancels every goal and ends the thread; returns when all are gone or at the deadline.
  void stop(std::chrono::steady_clock::time_point deadline);

 private:
  void run();

  const api::SnapshotSource& source_;
  const std::chrono::milliseconds write_timeout_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::shared_ptr<TrajectoryStream>> streams_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace aprsim::grpc_server
