#pragma once

#include "world/api/snapshot/robot_snapshot.hpp"
#include "world/base/result.hpp"

namespace aprsim::web {

/// Error for a robot that is not ready to be moved; kFailedPrecondition.
[[nodiscard]] inline Result<void> check_ready(const api::RobotSnapshot& robot) {
  if (robot.motion.source == api::MotionSource::kStream) {
    return fail(ErrorCode::kFailedPrecondition, "robot",
                robot.motion.commander + " has the robot by a stream of motions: stop it first.");
  }
  if (robot.initialized) return {};
  std::string message = "The robot is not ready: make it ready first.";
  if (robot.action.state == api::ActionState::kError) {
    message += " It holds an error: " + robot.action.description;
  }
  return fail(ErrorCode::kFailedPrecondition, "robot", std::move(message));
}

}  // namespace aprsim::web
