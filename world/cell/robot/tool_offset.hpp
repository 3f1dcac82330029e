#pragma once

#include "world/api/commands/robot_command.hpp"
#include "world/faults/robot_faults.hpp"

namespace aprsim::world {

/// Offset of a robot whose base or tool is not where its controller believes: the tool goes
/// elsewhere than it is sent. R = the robot's frame.
class ToolOffset {
 public:
  explicit ToolOffset(const RobotFaults& faults)
      : base_(faults.base_offset.isometry()), tool_(faults.tool_offset.isometry()) {}

  /// The command whose poses are where the tool really goes.
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
