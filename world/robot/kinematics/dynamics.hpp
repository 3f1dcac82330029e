#pragma once

#include "world/robot/model/arm_model.hpp"

/// Rigid-body dynamics of an arm with a rigid payload at the flange. No call allocates.
namespace aprsim::robot {

/// Gripper and held part as one rigid body, in flange axes.
struct Payload {
  double mass_kg = 0;
  Eigen::Vector3d com_F = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia_F = Eigen::Matrix3d::Zero();  ///< about its com
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
