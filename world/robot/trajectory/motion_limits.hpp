#pragma once

#include <array>
#include <functional>
#include <optional>

#include "world/api/robot_command.hpp"
#include "world/api/snapshot.hpp"
#include "world/robot/kinematics/dynamics.hpp"
#include "world/robot/model/arm_model.hpp"

namespace aprsim::robot {

/// Limits of each joint's motion; SI.
struct JointLimits {
  JointVector lower, upper;
  JointVector speed, accel, jerk;
};

/// Limits of the tool's motion in space; SI.
struct ToolLimits {
  double trans_speed_m_s = 0, trans_accel_m_s2 = 0;
  double rot_speed_rad_s = 0, rot_accel_rad_s2 = 0;
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

/// The time scale of a planned motion with which no drive needs more than kTorqueShare of its
/// maximal torque: the factor on its speeds (its square on the accelerations), 1 where it need not
/// be slowed. `position` gives the joints at a time in 0..duration, and is sampled at fixed shares
/// of the duration. Thread: any.
[[nodiscard]] double torque_scaling(const ArmModel& model, const Payload& payload,
                                    const Eigen::Vector3d& gravity_B, double duration_s,
                                    const std::function<JointVector(double)>& position);

/// The limits that moves of the tool obey, as set by commands. At start 0.25 m/s, 2 m/s^2, 1 rad/s
/// and 5 rad/s^2, or the robot's maximum where that is lower.
class ToolLimitSettings {
 public:
  explicit ToolLimitSettings(const ToolLimits& maximum);

  /// A value > 0, or a fraction in (0, 1]. A value above the maximum is clamped to it.
  void set(const api::SetMotionLimit& setting);

  [[nodiscard]] api::LimitSetting get(api::MotionLimit which) const;
  [[nodiscard]] ToolLimits effective() const;
  /// The same with what a pose sets for the way to it; clamped to the maximum.
  [[nodiscard]] ToolLimits effective(const api::PoseLimits& own) const;
  [[nodiscard]] const ToolLimits& maximum() const { return maximum_; }

 private:
  [[nodiscard]] double value(api::MotionLimit which,
                             const std::optional<api::LimitSetting>& own = {}) const;

  ToolLimits maximum_;
  std::array<api::LimitSetting, 4> settings_;
};

}  // namespace aprsim::robot
