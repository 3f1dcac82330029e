#pragma once

#include <cmath>
#include <span>

#include "world/robot/model/arm_model.hpp"

/// Forward kinematics of an arm, and its rigid-body dynamics with a rigid payload at the flange.
/// B = base mounting frame, F = flange, L = link. No call allocates.
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

/// Gripper and held part as one rigid body, in flange axes.
struct Payload {
  double mass_kg = 0;
  Eigen::Vector3d com_F = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia_F = Eigen::Matrix3d::Zero();  ///< about its com

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [mass_kg, com_F, inertia_F] = self;
    io(mass_kg, com_F, inertia_F);
  }
};

/// Joint torques for (q, qd, qdd), recursive Newton-Euler algorithm, with rotor inertia.
/// `gravity_B` is the gravitational acceleration in base axes [m/s^2].
[[nodiscard]] JointVector inverse_dynamics(const ArmModel& model, const Payload& payload,
                                           const Eigen::Vector3d& gravity_B, const JointVector& q,
                                           const JointVector& qd, const JointVector& qdd);

/// Joint-space inertia matrix, composite rigid body algorithm, with rotor inertia.
[[nodiscard]] JointMatrix mass_matrix(const ArmModel& model, const Payload& payload,
                                      const JointVector& q);

}  // namespace aprsim::robot
