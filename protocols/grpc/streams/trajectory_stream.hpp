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

#include "aprsim/v1/trajectory_service.pb.h"
#include "protocols/grpc/streams/bounded_stream.hpp"
#include "world/api/ports/ports.hpp"

namespace aprsim::grpc_server {

class TrajectoryHub;

/// A goal that has been submitted.
struct SubmittedGoal {
  api::Ticket ticket = 0;  ///< also the number of the stream
  int robot = 0;
  std::shared_ptr<const api::CellDescription> cell;  ///< where the robot has this index
  std::vector<std::size_t> joints;                   ///< of the robot, in the goal's order
  SimTime feedback_period{};                         ///< 0 = no feedback
  /// Stops the robot's motion by this goal. Thread: any.
  std::function<void()> cancel;
};

/// One client's goal: acceptance, feedback and result, with at most one write in flight. A slow
/// reader misses feedback, never the result. The end of the call in mid-motion cancels the goal.
class TrajectoryStream final : public BoundedStream<v1::FollowJointTrajectoryResponse> {
 public:
  TrajectoryStream(grpc::CallbackServerContext& context, TrajectoryHub& hub,
                   const api::SnapshotSource& source, SubmittedGoal goal);

  /// Sends what a snapshot has for the goal, if nothing is in flight. Thread: the hub's.
  void look(const api::Snapshot& snapshot);

  void OnDone() override;

  /// Owned by the call: set right after construction, released in OnDone.
  std::shared_ptr<TrajectoryStream> self;

 private:
  void next(Lock lock) override;
  void stop() override;
  void look(const api::Snapshot& snapshot, Lock lock);
  void await_acceptance(const api::Snapshot& snapshot, Lock lock);
  void write(Lock lock);
  void write_feedback(const api::Snapshot& snapshot, const api::RobotSnapshot& robot, Lock lock);

  TrajectoryHub& hub_;
  const api::SnapshotSource& source_;
  const SubmittedGoal goal_;

  v1::FollowJointTrajectoryResponse response_;
  bool accepted_ = false;
  bool over_ = false;  // the goal
  SimTime next_feedback_{};
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
