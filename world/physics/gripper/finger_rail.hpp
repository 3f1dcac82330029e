#pragma once

#include <Eigen/Core>

#include "world/physics/bodies/rigid_body.hpp"
#include "world/physics/gripper/finger_drive.hpp"

namespace aprsim::physics {

/// The rail of a finger on its palm: a prismatic joint along the finger's closing direction.
class FingerRail {
 public:
  FingerRail() = default;
  /// Both bodies as they are when the gripper is open; `closing_W`: in world, as the joint's axis.
  FingerRail(const RigidBody& finger, const RigidBody& palm, const Eigen::Vector3d& closing_W);

  /// Travel and its rate, from both bodies' poses and velocities.
  [[nodiscard]] FingerMotion motion(const RigidBody& finger, const RigidBody& palm) const;
  /// Loads both bodies with a force along the axis, closing positive, and its reaction. They act
  /// halfway between the centres of mass and leave no net torque.
  void apply_force(RigidBody& finger, RigidBody& palm, double force_n) const;

 private:
  [[nodiscard]] Eigen::Vector3d axis_W(const RigidBody& finger) const;

  Eigen::Vector3d axis_F_ = Eigen::Vector3d::UnitY();  // in the finger's frame
  Eigen::Vector3d open_P_ = Eigen::Vector3d::Zero();   // the open finger in the palm's frame
};

}  // namespace aprsim::physics
