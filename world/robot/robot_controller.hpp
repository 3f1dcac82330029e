#pragma once

#include <memory>
#include <string>

#include "world/api/command.hpp"
#include "world/api/snapshot.hpp"
#include "world/robot/arm_model.hpp"
#include "world/robot/inverse_kinematics.hpp"

namespace aprsim::robot {

/// What a robot controller is told at start; SI.
struct ControllerSetup {
  ArmModel model;
  std::shared_ptr<const InverseKinematics> ik;
  Eigen::Isometry3d X_BR = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d X_FT = Eigen::Isometry3d::Identity();
  JointVector q_home;
  double step_s = 1e-3;
  double max_trans_speed_m_s = 0, max_trans_accel_m_s2 = 0;
  double max_rot_speed_rad_s = 0, max_rot_accel_rad_s2 = 0;
};

/// The robot controller's state machine: takes commands, plans motion, gives one joint reference a
/// step. Knows units of SI only and nothing of CRCL ids. Thread: sim.
class RobotController {
 public:
  explicit RobotController(ControllerSetup setup);
  ~RobotController();

  /// Takes one command at a step boundary; the newest replaces whatever was running. `q_actual` is
  /// the arm's present position. The outcome shows in status().
  void take(api::Ticket ticket, const api::RobotAction& action, const JointVector& q_actual);

  /// Advances one step and returns the reference for its end. `gripper_settled`: the gripper has
  /// reached what was commanded (open end, closed end or a grasp).
  const JointVector& step(bool gripper_settled);

  /// Protective stop: motion ends at once at `q_actual`, the state is error with `reason` until
  /// InitRobot.
  void protective_stop(const std::string& reason, const JointVector& q_actual);

  [[nodiscard]] const api::ActionStatus& status() const;
  [[nodiscard]] const JointVector& reference() const;
  [[nodiscard]] double gripper_setting() const;  ///< 0..1
  [[nodiscard]] bool initialized() const;
  [[nodiscard]] bool stopped_by_protection() const;
  [[nodiscard]] bool moving() const;
  [[nodiscard]] api::LimitSetting limit(api::MotionLimit which) const;
};

}  // namespace aprsim::robot
