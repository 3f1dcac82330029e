#pragma once

#include <string>

#include "world/robot/controller/controller_state.hpp"
#include "world/robot/controller/robot_controller.hpp"
#include "world/robot/planning/motion_planner.hpp"

namespace aprsim::robot {

/// What is behind RobotController: what does not change, the state, and the commands on it.
struct RobotController::Core {
  explicit Core(ControllerSetup given);

  // ---- commands
  void execute(const api::InitRobot&, const JointVector& q_actual);
  void execute(const api::EndRobot&, const JointVector& q_actual);
  void execute(const api::StopMotion& stop, const JointVector& q_actual);
  void execute(const api::MoveTo& move, const JointVector& q_actual);
  void execute(const api::MoveThroughTo& move, const JointVector& q_actual);
  void execute(const api::MoveScrew& screw, const JointVector& q_actual);
  void execute(const api::MoveJoints& move, const JointVector& q_actual);
  void execute(const api::SetGripper& gripper, const JointVector& q_actual);
  void execute(const api::SetToolChanger& changer, const JointVector& q_actual);
  void execute(const api::SetGripperForce& set, const JointVector& q_actual);
  void execute(const api::SetOverride& setting, const JointVector& q_actual);
  void execute(const api::Dwell& dwell, const JointVector& q_actual);
  void execute(const api::SetMotionLimit& setting, const JointVector& q_actual);

  /// Whether the robot takes commands that act; else the state is error.
  bool ready();
  void set_error(const std::string& reason);
  /// Where the command just taken leads the tool.
  void note_goal();
  void working(Task what);
  void done();

  // ---- motion
  /// Brakes what runs, forgets what was to follow; returns where the robot will be at rest.
  JointVector brake(Brake how);
  void stop_at_once(const JointVector& from);
  /// Where the reference is and how it moves.
  [[nodiscard]] PassingState passing() const;
  /// Lets the motion planned in `next` follow what runs, or refuses the command.
  void start(const Result<void>& planned);
  /// Lets it begin at once if it can pass over from what runs.
  void start_in_passing(const ToolLimits& tool);
  void drive_by_torque(const api::MoveJoints& move, const JointVector& from);
  void arrived();
  /// Whether an arm that was at `q_actual` before this step (empty: at the reference) is near
  /// enough.
  [[nodiscard]] bool near_enough(const JointVector& q_actual) const;
  void change_tool(bool tool_at_flange);
  void switch_drives_on();
  void advance();
  void press(const JointVector& external_nm);
  void retreat(const JointVector& from);
  [[nodiscard]] PlanStart plan_start(const JointVector& q) const;
  [[nodiscard]] ArmGeometry arm() const { return {setup.model, *setup.ik}; }
  [[nodiscard]] bool resting() const { return !s.is_running && !s.has_next && !presses(); }
  /// A joint driven by torque is still on its way.
  [[nodiscard]] bool presses() const { return s.torque.active() && !s.torque.settled(); }
  [[nodiscard]] Eigen::Isometry3d X_FT() const;

  ControllerSetup setup;
  MotionPlanner planner;
  ControllerState s;
};

}  // namespace aprsim::robot
