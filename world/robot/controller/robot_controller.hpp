#pragma once

#include <memory>
#include <optional>
#include <string>

#include "world/api/robot_command.hpp"
#include "world/api/robot_snapshot.hpp"
#include "world/robot/kinematics/dynamics.hpp"
#include "world/robot/kinematics/inverse_kinematics.hpp"
#include "world/robot/model/arm_model.hpp"

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
  Payload payload;  ///< gripper and the heaviest part: motions are planned to carry it
  Eigen::Vector3d gravity_B{0, 0, -9.81};
};

/// What a controller is told about its robot each step.
struct ControllerInput {
  /// The gripper has reached what was commanded (open end, closed end or a grasp).
  bool gripper_settled = true;
  bool tool_at_flange = true;  ///< the tool changer could take the gripper
  JointVector external_nm{};   ///< contact torques on the joints; empty = none
  JointVector q_actual{};      ///< where the arm is; empty = at the reference
};

struct ControllerState;

/// The robot controller's state machine: takes commands, plans motion, gives one joint reference a
/// step. Knows units of SI only and nothing of CRCL ids. Thread: sim.
///
/// - Before InitRobot, and after EndRobot, only InitRobot, EndRobot, StopMotion and SetMotionLimit
///   are executed. An error is held: the state stays kError, whatever is sent, until InitRobot.
/// - The newest command replaces the one that runs, which then never becomes done. Moves of joints
///   and free moves of the tool begin at once, passing over from the motion that runs; the others
///   begin where it comes to rest on its own path. SetMotionLimit is for later moves and leaves a
///   running motion alone; SetOverride changes its speed.
/// - A command is done when the reference has reached its target exactly and is at rest, and the
///   arm, if something pushes it aside, is within the command's tolerance; SetGripper when the
///   gripper has settled, or 2 s after the command if it does not; a joint driven by torque when it
///   has reached its position or stands still against what bears the torque, and it keeps pressing
///   until the next motion.
/// - An immediate stop, and a fast one a second later, leaves the arm to its brakes with the drives
///   off. InitRobot and every motion switch them on again and wait until the brakes have released.
/// - After a protective stop the arm backs off some millimetres on its way; InitRobot waits for it.
class RobotController {
 public:
  /// Throws std::invalid_argument for a setup that makes no robot (limits not > 0, home outside the
  /// joint limits, no inverse kinematics).
  explicit RobotController(ControllerSetup setup);
  ~RobotController();
  RobotController(RobotController&&) noexcept;
  RobotController& operator=(RobotController&&) noexcept;

  /// Takes one command at a step boundary; the newest replaces whatever was running. `q_actual` is
  /// the arm's present position: InitRobot takes it over as the reference (the arm is to be relaxed
  /// with it), the others go on from the reference. The outcome shows in status().
  void take(api::Ticket ticket, const api::RobotAction& action, const JointVector& q_actual);

  /// Advances one step and returns the reference for its end; the same bits while nothing moves.
  /// `input` is what was seen before this step. Does not allocate.
  const JointVector& step(const ControllerInput& input = {});

  /// Protective stop: motion ends at once at `q_actual`, then backs off; the state is error with
  /// `reason` until InitRobot.
  void protective_stop(const std::string& reason, const JointVector& q_actual);
  /// The same where nothing has been hit: motion ends by braking hard on its path.
  void protective_stop(const std::string& reason);

  /// A guard has triggered: motion ends on its path as fast as it can. If `ends_command`, the
  /// present command is done at rest, with `why` as its description.
  void stop_by_guard(bool ends_command, const std::string& why);
  /// The present command is in error, held until InitRobot; motion brakes.
  void fail(const std::string& reason);

  [[nodiscard]] const api::ActionStatus& status() const;
  /// Where the running motion is to take the tool, in R; none when nothing is on its way.
  [[nodiscard]] std::optional<Pose> X_RG() const;
  [[nodiscard]] const JointVector& reference() const;
  [[nodiscard]] double gripper_setting() const;  ///< 0..1; 1 at start
  [[nodiscard]] bool initialized() const;
  [[nodiscard]] bool stopped_by_protection() const;
  [[nodiscard]] bool moving() const;
  [[nodiscard]] api::LimitSetting limit(api::MotionLimit which) const;
  /// After a protective stop, on the way back.
  [[nodiscard]] bool backing_off() const;
  [[nodiscard]] bool drives_on() const;
  [[nodiscard]] bool braked() const;  ///< the arm's brakes hold it
  [[nodiscard]] double override_fraction() const;
  [[nodiscard]] bool tool_mounted() const;
  [[nodiscard]] Eigen::Isometry3d X_FT() const;  ///< of the tool, or the flange itself without one
  /// Torques with which joints press on purpose [Nm].
  [[nodiscard]] JointVector pressing() const;

  /// Everything that changes (controller_state.hpp): a copy put back continues bit for bit, also in
  /// another controller of the same setup.
  [[nodiscard]] const ControllerState& state() const;
  void restore(const ControllerState& state);

 private:
  struct Core;
  std::unique_ptr<Core> core_;
};

}  // namespace aprsim::robot
