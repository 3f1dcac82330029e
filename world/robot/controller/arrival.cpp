#include "world/robot/controller/arrival.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "world/robot/kinematics/kinematics.hpp"

namespace aprsim::robot {
namespace {

constexpr double kResolution = 1e-6;  ///< of the servo [m, rad]

bool within(const std::optional<double>& tolerance, double deviation) {
  return !tolerance || std::abs(deviation) <= std::max(*tolerance, kResolution);
}

}  // namespace

bool has_arrived(const ArrivalTolerance& tolerance, const ArmModel& model,
                 const Eigen::Isometry3d& X_RB, const Eigen::Isometry3d& X_FT, const JointVector& q,
                 const JointVector& target) {
  // The common case: nothing pushes the arm aside.
  if (q == target) return true;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    if (!within(tolerance.joint_rad[static_cast<std::size_t>(i)], q(i) - target(i))) return false;
  }
  // Deviation of the tool in R: of its position, and of its x and z axis (CRCL's
  // PoseToleranceType).
  const api::PoseTolerance& pose = tolerance.pose;
  const bool any = pose.x_m || pose.y_m || pose.z_m || pose.x_axis_rad || pose.z_axis_rad;
  if (!any) return true;
  const Eigen::Isometry3d X_RT = X_RB * flange_pose(model, q) * X_FT;
  const Eigen::Isometry3d X_RT_target = X_RB * flange_pose(model, target) * X_FT;
  const Eigen::Vector3d off = X_RT.translation() - X_RT_target.translation();
  const auto axis_off = [&](int axis) {
    return angle_between(X_RT.linear().col(axis), X_RT_target.linear().col(axis));
  };
  return within(pose.x_m, off.x()) && within(pose.y_m, off.y()) && within(pose.z_m, off.z()) &&
         within(pose.x_axis_rad, axis_off(0)) && within(pose.z_axis_rad, axis_off(2));
}

}  // namespace aprsim::robot
