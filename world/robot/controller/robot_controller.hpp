#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "world/api/commands/robot_command.hpp"
#include "world/api/commands/trajectory_command.hpp"
#include "world/api/snapshot/robot_snapshot.hpp"
#include "world/base/result.hpp"
#include "world/robot/controller/controller_setup.hpp"
#include "world/robot/controller/controller_state.hpp"
#include "world/robot/controller/equipped_arm.hpp"
#include "world/robot/controller/move_preview.hpp"

namespace aprsim::robot {

/// State of the robot before a step.
struct ControllerInput {
  /// The gripper has reached its setting (open end, closed end or a grasp).
  bool gripper_settled = true;
  int tool_at_flange = 0;     ///< the tool within the changer's capture range, -1 = none
  JointVector external_nm{};  ///< contact torques on the joints; empty = none
  JointVector q_actual{};     ///< where the arm is; empty = at the reference
  JointVector qd_actual{};    ///< how fast; empty = as the reference
};

/// State machine of the robot controller: executes commands, plans motion, generates one joint
/// reference per step. SI units; independent of CRCL. Thread: sim.
///
/// - Before InitRobot only InitRobot, EndProgram, StopMotion and SetMotionLimit are executed.
/// EndProgram
///   ends motion; the robot stays initialized. An error is held: the state stays kError until
///   InitRobot.
/// - The newest command replaces the one that runs, which then never becomes done. A move begins
///   after the planning latency; until then the motion before it continues. Moves of joints and
///   free moves of the tool are blended from the motion that runs then; the others begin where it
///   comes to rest on its own path. Moves that come while one is being planned wait for that; only
///   the last of them is planned. SetMotionLimit is for later moves and leaves a running motion
///   alone; SetOverride changes its speed. SetGripper and Dwell begin at once, concurrently with a
///   running or planned motion. That motion continues to its target. If it is refused or stopped,
///   the error is that of the latest command.
/// - The tool changer waits until the arm is at rest, and then for its own time. Commands received
///   meanwhile are executed after it, in order, except stops, InitRobot and EndProgram.
/// - A command is done when the reference has reached its target exactly and is at rest, and the
///   arm, if something pushes it aside, is within the command's tolerance; SetGripper when the
///   gripper has settled, or 2 s after the command if it does not. A joint in torque mode is done
///   at its position or at rest in balance with its load; it applies its torque until the next
///   motion.
/// - An immediate stop, and a fast one a second later, engages the brakes and switches the drives
/// off. InitRobot and every motion switch them on again and wait until the brakes have released.
/// - While a stream has the robot (world/api/commands/trajectory_command.hpp), commands that move,
///   initialize or change the tool are refused as busy; the others are executed. Every stop of the
///   robot ends the stream.
/// - After a protective stop the arm retreats some millimetres along its trail; InitRobot waits for
///   that.
class RobotController {
 public:
  /// Throws std::invalid_argument for a setup that makes no robot (limits not > 0, home outside the
  /// joint limits, no inverse kinematics).
  explicit RobotController(ControllerSetup setup);

  /// Executes one command at a step boundary; the newest replaces the running one. Its indices
  /// and numbers have been checked (world/cell/commands/command_check.hpp). `q_actual` is the arm's
  /// present position: InitRobot makes it the reference (the arm is to be relaxed with it), the
  /// others continue from the reference. The outcome is in status().
  void apply(api::Ticket ticket, const api::RobotAction& action, const JointVector& q_actual);

  /// Executes a command of a stream; the latest command and its progress stay as they are. `delay`:
  /// steps until the start of a followed trajectory, negative for one that has passed. `q_actual`
  /// as above, for a reset. Errors as of the command.
  [[nodiscard]] Result<void> apply(api::Ticket ticket, const api::TrajectoryAction& action,
                                   std::int64_t delay, const JointVector& q_actual);

  /// Advances one step and returns the reference for its end; the same bits while nothing moves.
  /// `input` is the robot's state before this step. Does not allocate.
  const JointVector& step(const ControllerInput& input = {});

  /// Protective stop: motion ends at once at `q_actual`, then retreats; the state is error with
  /// `reason` until InitRobot.
  void protective_stop(const std::string& reason, const JointVector& q_actual);
  /// The same without a collision: motion ends by braking hard on its path.
  void protective_stop(const std::string& reason);

  /// A guard has triggered: motion ends on its path as fast as it can. If `ends_command`, the
  /// present command is done at rest, with `why` as its description.
  void stop_by_guard(bool ends_command, const std::string& why);
  /// The present command is in error, held until InitRobot; motion brakes.
  void fail(const std::string& reason);
  /// The same; motion ends at once, or on its path as fast as it can, and then the drives go off.
  void shut_down(const std::string& reason, bool on_path);
  /// Rejects a command: it is in error at once, held until InitRobot.
  void refuse(api::Ticket ticket, const api::RobotAction& action, const std::string& reason);
  /// From now on every motion has this share of its speed.
  void slow_down(double share);

  /// The move as it would be planned and made if it were commanded now, in `mode` or in the one
  /// that is set. Changes nothing. Errors: kFailedPrecondition where the command would be refused
  /// before it is planned.
  [[nodiscard]] Result<std::shared_ptr<MovePreview>> preview(
      PlannedMove move, std::optional<api::PlanningMode> mode) const;

  // ---- state

  [[nodiscard]] const api::ActionStatus& status() const { return s_.command.status(); }
  /// Goal pose of the tool in R while a motion runs.
  [[nodiscard]] std::optional<Pose> X_RG() const;
  [[nodiscard]] const JointVector& reference() const { return s_.motion.reference(); }
  [[nodiscard]] double gripper_setting() const { return s_.gripper_setting; }  ///< 0..1; 1 at start
  [[nodiscard]] const MotionStream& stream() const { return s_.stream; }
  /// The source of the motion and its progress.
  void write(api::MotionSnapshot& out) const;
  [[nodiscard]] bool initialized() const { return s_.command.initialized(); }
  [[nodiscard]] bool stopped_by_protection() const { return s_.protection; }
  [[nodiscard]] bool moving() const { return !at_rest(); }
  [[nodiscard]] api::LimitSetting limit(api::MotionLimit which) const {
    return s_.tool_limits.get(which);
  }
  /// After a protective stop, on the way back.
  [[nodiscard]] bool retreating() const { return s_.motion.retreating(); }
  /// How later moves regard what stands around.
  [[nodiscard]] api::PlanningMode planning() const { return s_.planning; }
  /// Along the latest motion that was checked, in R [m]; null = there is none.
  [[nodiscard]] const std::shared_ptr<const std::vector<Eigen::Vector3d>>& path() const {
    return s_.path;
  }
  [[nodiscard]] std::uint64_t motions_begun() const { return s_.motions_begun; }
  /// Adds the reference and positions on the way that is left, `count` for each motion.
  void remaining(std::size_t count, std::vector<JointVector>& out) const {
    s_.motion.remaining(count, out);
  }
  [[nodiscard]] bool drives_on() const { return s_.motion.drives().on(); }
  /// The arm's brakes hold it.
  [[nodiscard]] bool braked() const { return s_.motion.drives().braked(); }
  [[nodiscard]] double override_fraction() const { return s_.motion.override_fraction(); }
  /// On the flange, -1 = none.
  [[nodiscard]] int tool() const { return s_.changer.tool(); }
  /// The frame that poses are of.
  [[nodiscard]] const Eigen::Isometry3d& X_FT() const { return arm().X_FT; }
  /// Torques that the joints in torque mode apply [Nm], >= 0; the others 0.
  [[nodiscard]] JointVector applied_torque() const {
    return s_.motion.applied_torque(setup_.model.dof());
  }

  /// Everything that changes: a restored copy continues bit for bit, also in another controller of
  /// the same setup.
  [[nodiscard]] ControllerState save() const;
  void restore(const ControllerState& state);

  /// Number of steps that waited for a plan, since construction. It depends on the machine's load.
  [[nodiscard]] std::uint64_t plan_waits() const { return plan_waits_; }

 private:
  // ---- commands
  void run(api::Ticket ticket, const api::RobotAction& action, const JointVector& q_actual);
  void execute(const api::InitRobot&, const JointVector& q_actual);
  void execute(const api::EndProgram&, const JointVector& q_actual);
  void execute(const api::StopMotion& stop, const JointVector& q_actual);
  void execute(const api::MoveTo& move, const JointVector&) { plan(move); }
  void execute(const api::MoveThroughTo& move, const JointVector&) { plan(move); }
  void execute(const api::MoveScrew& move, const JointVector&) { plan(move); }
  void execute(const api::MoveJoints& move, const JointVector&) { plan(move); }
  void execute(const api::SetGripper& gripper, const JointVector& q_actual);
  void execute(const api::SetToolChanger& changer, const JointVector& q_actual);
  /// The force itself is SimulatedRobot's.
  void execute(const api::SetGripperForce&, const JointVector&) { s_.command.complete(); }
  void execute(const api::SetOverride& setting, const JointVector& q_actual);
  void execute(const api::Dwell& dwell, const JointVector& q_actual);
  void execute(const api::SetMotionLimit& setting, const JointVector& q_actual);
  void execute(const api::SetPlanning& setting, const JointVector& q_actual);

  [[nodiscard]] bool refuse_as_busy(api::Ticket ticket, const api::RobotAction& action);

  // ---- streams
  [[nodiscard]] Result<void> require_free() const;
  [[nodiscard]] Result<void> claim(api::Ticket ticket, const api::ClaimMotion& command,
                                   const JointVector& q_actual);
  [[nodiscard]] Result<void> follow(api::Ticket ticket, const api::FollowTrajectory& command,
                                    std::int64_t delay, const JointVector& q_actual);
  void reset(const JointVector& q_actual);
  [[nodiscard]] MotionStream::Arm stream_arm() { return {arm(), setup_.gravity_B, s_.motion}; }

  // ---- planning
  void plan(PlannedMove move);
  void begin_planning(MoveRequest request, bool search = false, int replans = 0);
  [[nodiscard]] bool is_outdated(const PlanRequest& request) const;
  void begin_planned();

  // ---- tool changer
  void defer(api::Ticket ticket, const api::RobotAction& action);
  void finish_tool_change();
  void run_deferred();

  // ---- completion
  void check_completion(const ControllerInput& input);
  [[nodiscard]] bool has_arrived(const JointVector& q_actual) const;
  void complete_motion();

  // ---- state
  void begin_task(Task task);
  [[nodiscard]] bool require_initialized();
  void brake(Brake how);
  void stop_from(const JointVector& q);
  void update_goal();
  [[nodiscard]] bool at_rest() const { return s_.motion.at_rest() && !s_.plans.planning(); }
  /// With the tool that is on it.
  [[nodiscard]] const EquippedArm& arm() const {
    return tool() >= 0 ? arms_[static_cast<std::size_t>(tool())] : arms_.back();
  }
  [[nodiscard]] api::PlanningMode mode() const {
    return setup_.surroundings ? s_.planning : api::PlanningMode::kDirect;
  }
  [[nodiscard]] int latency_steps(const PlannedMove& move, bool search) const {
    return planning_steps(setup_.latency, setup_.step_s, move, search, mode());
  }

  ControllerSetup setup_;
  std::vector<EquippedArm> arms_;  // by tool, then that without one
  ControllerState s_;
  std::uint64_t plan_waits_ = 0;
};

}  // namespace aprsim::robot
