#pragma once

#include <Eigen/Geometry>

#include "world/robot/planning/motion_planner.hpp"

namespace aprsim::robot {

/// An arm with the tool that is on its flange, or with none: the constants of its motions. Copies
/// share the arm.
struct EquippedArm {
  MotionPlanner planner;                                   ///< with the tool's payload
  Eigen::Isometry3d X_FT = Eigen::Isometry3d::Identity();  ///< the frame that poses are of
  double step_s = 1e-3;

  [[nodiscard]] const ArmModel& model() const { return planner.arm().model; }
};

}  // namespace aprsim::robot
