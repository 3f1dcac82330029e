#pragma once

#include <cmath>
#include <span>

#include "world/robot/model/arm_model.hpp"

/// Forward kinematics. B = base mounting frame, F = flange, L = link. No call allocates.
namespace aprsim::robot {

/// X_BL of every link into `X_BL` (dof + 1 entries; the last is X_BF).
void link_poses(const ArmModel& model, const JointVector& q, std::span<Eigen::Isometry3d> X_BL);

[[nodiscard]] Eigen::Isometry3d flange_pose(const ArmModel& model, const JointVector& q);

/// Geometric Jacobian, in base axes, of the point `p_L` fixed to link `link` (index into links).
[[nodiscard]] Jacobian point_jacobian(const ArmModel& model, const JointVector& q, int link,
                                      const Eigen::Vector3d& p_L);

/// From one direction to another [rad], exact for the smallest angles too.
[[nodiscard]] inline double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace aprsim::robot
