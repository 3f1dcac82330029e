#pragma once

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "world/robot/model/arm_model.hpp"

namespace aprsim::robot {

/// R <- R Rot(axis, angle). An axis along a coordinate axis, as nearly all joints have, mixes just
/// two columns.
inline void rotate_by(Eigen::Matrix3d& R, const Eigen::Vector3d& axis, double angle) {
  for (int k = 0; k < 3; ++k) {
    if (std::abs(axis(k)) != 1) continue;
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const double c = std::cos(angle), s = axis(k) * std::sin(angle);
    const Eigen::Vector3d old = R.col(i);
    R.col(i) = c * old + s * R.col(j);
    R.col(j) = c * R.col(j) - s * old;
    return;
  }
  R = R * Eigen::AngleAxisd(angle, axis).toRotationMatrix();
}

/// Rotation of the link behind a joint in its parent.
[[nodiscard]] inline Eigen::Matrix3d joint_rotation(const Joint& joint, double q) {
  Eigen::Matrix3d R_PL = joint.X_PJ.linear();
  if (!joint.prismatic) rotate_by(R_PL, joint.axis, q);
  return R_PL;
}

/// Longest distance of the link behind a joint from the joint before, whatever the joint does [m].
[[nodiscard]] inline double longest_offset(const Joint& joint) {
  const double travel =
      joint.prismatic ? std::max(std::abs(joint.lower_rad), std::abs(joint.upper_rad)) : 0;
  return joint.X_PJ.translation().norm() + travel;
}

/// Distance of the flange from the frame that the last joint moves [m].
[[nodiscard]] inline double flange_offset(const ArmModel& model) {
  return model.X_LF ? model.X_LF->translation().norm() : 0;
}

/// Origin of the link behind a joint in its parent [m].
[[nodiscard]] inline Eigen::Vector3d joint_offset(const Joint& joint, double q) {
  if (!joint.prismatic) return joint.X_PJ.translation();
  return joint.X_PJ.translation() + joint.X_PJ.linear() * joint.axis * q;
}

}  // namespace aprsim::robot
