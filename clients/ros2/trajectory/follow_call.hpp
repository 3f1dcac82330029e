#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <thread>
#include <variant>

#include "aprsim/v1/trajectory_service.pb.h"
#include "clients/ros2/trajectory/goal.hpp"
#include "clients/wires/endpoints.hpp"

namespace aprsim::client {
class CellConnection;
}

namespace aprsim::ros2 {

/// The end of a call: the robot stands, or another commander has it.
struct FollowEnd {
  bool succeeded = false;
  bool cancelled = false;  ///< by cancel()
  ActionResult result;
};

/// A motion that is under way. The destructor stops it.
class MotionCall {
 public:
  virtual ~MotionCall() = default;
  /// Stops the robot; the end follows once it stands.
  virtual void cancel() = 0;
};

/// One call of the daemon's FollowJointTrajectory in a thread of its own. The destructor ends the
/// call, upon which the daemon stops the robot.
class FollowCall final : public MotionCall {
 public:
  using Event = std::variant<v1::TrajectoryFeedback, FollowEnd>;
  /// Gets each event, the end as the last one. Thread: the call's.
  using Sink = std::function<void(Event)>;

  FollowCall(const client::Endpoints& endpoints, v1::FollowJointTrajectoryRequest request,
             Sink sink);
  ~FollowCall() override;
  FollowCall(const FollowCall&) = delete;
  FollowCall& operator=(const FollowCall&) = delete;

  void cancel() override { cancelled_ = true; }

 private:
  void run(const client::Endpoints& endpoints);
  FollowEnd follow(client::CellConnection& connection);
  void await_rest(client::CellConnection& connection) const;

  v1::FollowJointTrajectoryRequest request_;
  Sink sink_;
  std::uint64_t stream_ = 0;  ///< number of the accepted stream; 0 = not accepted
  std::atomic<bool> cancelled_ = false;
  std::atomic<bool> over_ = false;  ///< nobody waits for the end
  std::thread thread_;
};

}  // namespace aprsim::ros2
