#pragma once

#include <Eigen/Core>

#include "world/base/result.hpp"
#include "world/robot/kinematics/dynamics.hpp"
#include "world/robot/model/arm_model.hpp"
#include "world/robot/trajectory/profile/joint_limits.hpp"
#include "world/robot/trajectory/stream/joint_curve.hpp"

namespace aprsim::robot {

/// The limits of an arm with its tool.
struct CurveLimits {
  const ArmModel& model;
  const JointLimits& joints;
  const Payload& payload;
  const Eigen::Vector3d& gravity_B;
};

/// Checks the curve between two points against the joints' ranges and speeds and the drives'
/// torques. Torques are checked at the ends of the curve and where its acceleration is extreme.
/// Errors: kUnreachable with the joint as field; the message names time, value, limit and unit.
/// Thread: any.
[[nodiscard]] Result<void> check_curve(const CurveLimits& limits, const CurvePoint& from,
                                       const CurvePoint& to);

/// Checks a posture against the joints' ranges. Errors as above.
[[nodiscard]] Result<void> check_posture(const CurveLimits& limits, const JointVector& q);

}  // namespace aprsim::robot
