#pragma once

#include "world/robot/kinematics/dynamics.hpp"
#include "world/robot/model/arm_model.hpp"

namespace aprsim::robot {

/// Limits of each joint's motion; SI.
struct JointLimits {
  JointVector lower, upper;
  JointVector speed, accel, jerk;

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [lower, upper, speed, accel, jerk] = self;
    io(lower, upper, speed, accel, jerk);
  }
};

/// Share of the drives' maximal torque that a planned motion may use; the rest is reserved for
/// contacts.
inline constexpr double kTorqueShare = 0.9;
/// An acceleration builds up over this time, which sets the jerk limits.
inline constexpr double kJerkTime_s = 0.1;

/// Position and speed limits as the model has them. An acceleration limit is what kTorqueShare of
/// the joint's maximal torque gives when gravity and the axis inertia are at their worst over the
/// joint ranges, and never more than reaching full speed within 0.2 s.
[[nodiscard]] JointLimits derive_joint_limits(const ArmModel& model, const Payload& payload,
                                              const Eigen::Vector3d& gravity_B);

}  // namespace aprsim::robot
