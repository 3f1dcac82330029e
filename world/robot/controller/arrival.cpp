#include "world/robot/controller/arrival.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "world/robot/kinematics/dynamics.hpp"

namespace aprsim::robot {
namespace {

// A tolerance below the servo's resolution could never be met, and the command would not end.
constexpr double kServoResolution = 1e-6;  ///< of the servo [m, rad]

bool within(const std::optional<double>& tolerance, double deviation) {
  return !tolerance || std::abs(deviation) <= std::max(*tolerance, kServoResolution);
}

bool any(const api::PoseTolerance& pose) {
  return pose.x_m || pose.y_m || pose.z_m || pose.x_axis_rad || pose.z_axis_rad;
}

/// Deviation of the tool in R: of its position, and of its x and z axis (CRCL's PoseToleranceType).
bool within(const api::PoseTolerance& tolerance, const Eigen::Isometry3d& X_RT,
            const Eigen::Isometry3d& X_RT_target) {
  // CRCL gives each axis its own tolerance. Two axes determine a rotation; the y axis needs none.
  const Eigen::Vector3d off = X_RT.translation() - X_RT_target.translation();
  const auto axis_off = [&](int axis) {
    return angle_between(X_RT.linear().col(axis), X_RT_target.linear().col(axis));
  };
  return within(tolerance.x_m, off.x()) && within(tolerance.y_m, off.y()) &&
         within(tolerance.z_m, off.z()) && within(tolerance.x_axis_rad, axis_off(0)) &&
         within(tolerance.z_axis_rad, axis_off(2));
}

}  // namespace

ArrivalTolerance arrival_tolerance_of(const PlannedMove& move) {
  ArrivalTolerance out;
  if (const auto* to = std::get_if<api::MoveTo>(&move)) {
    out.pose = to->tolerance;
  } else if (const auto* through = std::get_if<api::MoveThroughTo>(&move)) {
    out.pose = through->waypoints.back().tolerance;
  } else if (const auto* joints = std::get_if<api::MoveJoints>(&move)) {
    for (const api::JointTarget& target : joints->targets) {
      if (!target.tolerance_rad || target.torque) continue;
      out.joint_rad[static_cast<std::size_t>(target.joint)] = *target.tolerance_rad;
    }
  }
  return out;
}

bool has_arrived(const ArrivalTolerance& tolerance, const ArmModel& model,
                 const Eigen::Isometry3d& X_RB, const Eigen::Isometry3d& X_FT, const JointVector& q,
                 const JointVector& target) {
  // Exact equality holds: an undisturbed servo follows its reference bit for bit (ServoArm).
  // The common case: nothing pushes the arm aside.
  if (q == target) return true;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    if (!within(tolerance.joint_rad[static_cast<std::size_t>(i)], q(i) - target(i))) return false;
  }
  return !any(tolerance.pose) || within(tolerance.pose, X_RB * flange_pose(model, q) * X_FT,
                                        X_RB * flange_pose(model, target) * X_FT);
}

}  // namespace aprsim::robot
