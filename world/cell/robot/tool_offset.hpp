#pragma once

#include "world/api/commands/robot_command.hpp"
#include "world/faults/robot_faults.hpp"

namespace aprsim::world {

/// Calibration error of a robot's base or tool: the tool moves to other poses than commanded. R =
/// the robot's frame.
class ToolOffset {
 public:
  explicit ToolOffset(const RobotFaults& faults)
      : base_(faults.base_offset.isometry()), tool_(faults.tool_offset.isometry()) {}

  /// The command with the actual target poses of the tool.
  [[nodiscard]] api::RobotAction displaced(api::RobotAction action) const;
  /// The pose that the controller reports for a tool that is at `X_RT`.
  [[nodiscard]] Pose reported(const Pose& X_RT) const {
    return Pose::from(base_.inverse() * X_RT.isometry() * tool_.inverse());
  }

 private:
  [[nodiscard]] Pose displaced(const Pose& X_RT) const {
    return Pose::from(base_ * X_RT.isometry() * tool_);
  }

  Eigen::Isometry3d base_, tool_;
};

}  // namespace aprsim::world
