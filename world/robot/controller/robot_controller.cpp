#include "world/robot/controller/robot_controller.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "world/robot/kinematics/kinematics.hpp"
#include "world/robot/planning/screw_planner.hpp"
#include "world/robot/planning/waypoint_planner.hpp"

namespace aprsim::robot {
namespace {

const char* const kNotInitialized = "not initialized: the robot must be initialized first";
const char* const kNoTool =
    "the gripper is not on the robot: the tool changer is open; close it where the gripper is";
/// Retreat after a collision: of the tool, or of the joints where the tool hardly moves.
constexpr double kRetreat_m = 1e-2, kRetreat_rad = 0.03;
constexpr double kGripperDeadline_s = 2;
constexpr double kDrivesOffAfterFastStop_s = 1;
/// Release time of holding brakes of servo motors of this size, an estimate.
constexpr double kBrakeRelease_s = 0.1;
constexpr std::size_t kReasonCapacity = 512;

/// The setup, or an exception for one that makes no robot.
ControllerSetup checked(ControllerSetup setup) {
  if (!setup.ik) throw std::invalid_argument("robot controller: no inverse kinematics");
  if (!(setup.step_s > 0)) throw std::invalid_argument("robot controller: step must be > 0");
  if (setup.q_home.size() != setup.model.dof()) {
    throw std::invalid_argument("robot controller: home needs one value a joint");
  }
  for (int i = 0; i < setup.model.dof(); ++i) {
    const Joint& joint = setup.model.joints[static_cast<std::size_t>(i)];
    if (!(setup.q_home(i) >= joint.lower_rad && setup.q_home(i) <= joint.upper_rad)) {
      throw std::invalid_argument("robot controller: home of " + joint.name +
                                  " is outside its limits");
    }
  }
  return setup;
}

PlannerSetup planner_setup(const ControllerSetup& setup) {
  return {setup.model, setup.ik, setup.X_BR, setup.payload, setup.gravity_B};
}

ToolLimits tool_maximum(const ControllerSetup& setup) {
  return {setup.max_trans_speed_m_s, setup.max_trans_accel_m_s2, setup.max_rot_speed_rad_s,
          setup.max_rot_accel_rad_s2};
}

}  // namespace

RobotController::RobotController(ControllerSetup setup)
    : setup_(checked(std::move(setup))),
      planner_(planner_setup(setup_)),
      s_(tool_maximum(setup_), setup_.q_home) {
  s_.status.description.reserve(kReasonCapacity);
  s_.note.reserve(kReasonCapacity);
}

void RobotController::apply(api::Ticket ticket, const api::RobotAction& action,
                            const JointVector& q_actual) {
  s_.status.ticket = ticket;
  s_.status.kind = api::kind_of(action);
  std::visit([&](const auto& command) { execute(command, q_actual); }, action);
  update_goal();
}

const JointVector& RobotController::step(const ControllerInput& input) {
  // The reference of this step.
  s_.drive_power.step(at_rest());
  advance_motion();
  advance_torque_mode(input.external_nm);
  s_.retreat_trail.record(s_.reference);
  // The end of the command that runs.
  switch (s_.task) {
    case Task::kNone:
      break;
    case Task::kRest:
      if (at_rest() && !s_.drive_power.releasing() && within_tolerance(input.q_actual)) {
        complete_motion();
      }
      break;
    case Task::kGripper:
      // The input of the first step still belongs to the setting before.
      --s_.steps_left;
      if (at_rest() && s_.gripper_applied && (input.gripper_settled || s_.steps_left <= 0)) {
        complete_task();
      }
      s_.gripper_applied = true;
      break;
    case Task::kToolChanger:
      if (at_rest()) change_tool(input.tool_at_flange);
      break;
    case Task::kDwell:
      // The time runs from rest.
      if (at_rest() && --s_.steps_left <= 0) complete_task();
      break;
  }
  return s_.reference;
}

void RobotController::protective_stop(const std::string& reason, const JointVector& q_actual) {
  // The reference stands still where the arm is.
  s_.is_running = s_.has_next = s_.to_joint_targets = false;
  s_.torque_mode.clear();
  s_.reference = s_.last_reference = s_.second_last_reference = q_actual;
  s_.protection = true;
  set_error(reason);
  retreat(q_actual);
}

void RobotController::protective_stop(const std::string& reason) {
  brake(Brake::kHard);
  s_.protection = true;
  set_error(reason);
}

void RobotController::stop_by_guard(bool ends_command, const std::string& why) {
  brake(Brake::kHard);
  if (!ends_command) return;
  // The command ends well, with the trigger as its description.
  begin_task(Task::kRest);
  s_.note.assign(why, 0, kReasonCapacity);
}

void RobotController::fail(const std::string& reason) { set_error(reason); }

std::optional<Pose> RobotController::X_RG() const {
  return moving() && s_.held_error.empty() ? s_.X_RG : std::nullopt;
}

Eigen::Isometry3d RobotController::X_FT() const {
  return s_.tool_mounted ? setup_.X_FT : Eigen::Isometry3d::Identity();
}

// ---- commands

void RobotController::execute(const api::InitRobot&, const JointVector& q_actual) {
  s_.held_error.clear();
  s_.protection = false;
  s_.initialized = true;
  switch_drives_on();
  // A retreat from a collision comes first.
  if (!retreating()) stop_at_once(q_actual);
  begin_task(Task::kRest);
}

void RobotController::execute(const api::EndRobot&, const JointVector&) {
  s_.initialized = false;
  brake(Brake::kSet);
  begin_task(Task::kRest);
}

void RobotController::execute(const api::StopMotion& stop, const JointVector&) {
  switch (stop.kind) {
    case api::StopKind::kImmediate:
      stop_at_once(s_.reference);
      s_.drive_power.switch_off_after(0);
      break;
    case api::StopKind::kFast:
      brake(Brake::kHard);
      s_.drive_power.switch_off_after(
          static_cast<int>(std::lround(kDrivesOffAfterFastStop_s / setup_.step_s)));
      break;
    case api::StopKind::kNormal:
      brake(Brake::kSet);
      s_.drive_power.cancel_switch_off();
      break;
  }
  begin_task(Task::kRest);
}

void RobotController::execute(const api::MoveTo& move, const JointVector&) {
  if (!require_initialized()) return;
  const JointVector from = brake(Brake::kSet);
  // Planned from rest; a free move may then blend from the motion that brakes.
  enqueue(planner_.plan(move, plan_start(from), s_.tool_limits, s_.next));
  s_.arrival_tolerance.pose = move.tolerance;
  if (!move.straight) blend_from_running(s_.tool_limits.effective(move.limits));
}

void RobotController::execute(const api::MoveThroughTo& move, const JointVector&) {
  if (!require_initialized()) return;
  const JointVector from = brake(Brake::kSet);
  const WaypointPlanner planner(planner_, plan_start(from), s_.tool_limits);
  enqueue(planner.plan(move, s_.next));
  s_.arrival_tolerance.pose = move.waypoints.back().tolerance;
}

void RobotController::execute(const api::MoveScrew& screw, const JointVector&) {
  if (!require_initialized()) return;
  const JointVector from = brake(Brake::kSet);
  const ScrewPlanner planner(planner_, plan_start(from), s_.tool_limits);
  enqueue(planner.plan(screw, s_.next));
}

void RobotController::execute(const api::MoveJoints& move, const JointVector&) {
  if (!require_initialized()) return;
  s_.torque_mode_pending = s_.is_running || s_.torque_mode.active();
  // Joints that the command does not name keep the targets of the move that it replaces.
  const bool keep_targets = (s_.is_running || s_.has_next) && s_.to_joint_targets;
  const JointVector from = brake(Brake::kSet);
  if (!keep_targets) s_.joint_targets = from;
  enqueue(planner_.plan(move, plan_start(from), s_.tool_limits, s_.joint_targets, s_.next));
  s_.to_joint_targets = s_.has_next;
  for (const api::JointTarget& target : move.targets) {
    if (!target.tolerance_rad || target.torque) continue;
    s_.arrival_tolerance.joint_rad[static_cast<std::size_t>(target.joint)] = *target.tolerance_rad;
  }
  if (!s_.has_next) return;
  blend_from_running(s_.tool_limits.maximum());
  start_torque_mode(move, from);
}

void RobotController::execute(const api::SetGripper& gripper, const JointVector&) {
  if (!require_initialized()) return;
  if (!s_.tool_mounted) {
    set_error(kNoTool);
    return;
  }
  // The deadline is for a gripper that reports nothing.
  brake(Brake::kSet);
  s_.gripper_setting = gripper.setting;
  s_.gripper_applied = false;
  s_.steps_left = std::llround(kGripperDeadline_s / setup_.step_s);
  begin_task(Task::kGripper);
}

void RobotController::execute(const api::SetToolChanger& changer, const JointVector&) {
  if (!require_initialized()) return;
  brake(Brake::kSet);
  s_.changer_open = changer.open;
  begin_task(Task::kToolChanger);
}

/// The force itself is SimulatedRobot's.
void RobotController::execute(const api::SetGripperForce&, const JointVector&) { complete_task(); }

void RobotController::execute(const api::SetOverride& setting, const JointVector&) {
  // It applies to the running motion, but not to the braking of a protective stop.
  s_.override_fraction = setting.fraction;
  if (s_.is_running && !s_.protection) s_.running.set_speed(setting.fraction);
  if (s_.has_next) s_.next.set_speed(setting.fraction);
  complete_task();
}

void RobotController::execute(const api::Dwell& dwell, const JointVector&) {
  if (!require_initialized()) return;
  brake(Brake::kSet);
  // Whole steps, rounded up.
  const std::int64_t step_ns = std::llround(setup_.step_s * 1e9);
  const std::int64_t whole = dwell.duration.count() / step_ns;
  s_.steps_left = whole + (dwell.duration.count() % step_ns != 0 ? 1 : 0);
  begin_task(Task::kDwell);
}

void RobotController::execute(const api::SetMotionLimit& setting, const JointVector&) {
  s_.tool_limits.set(setting);
  complete_task();
}

// ---- status

bool RobotController::require_initialized() {
  if (!s_.held_error.empty()) return false;  // the state is error already
  if (!s_.initialized) set_error(kNotInitialized);
  return s_.initialized;
}

/// The error is held, and the motion brakes.
void RobotController::set_error(const std::string& reason) {
  s_.held_error = reason;
  s_.initialized = false;
  s_.task = Task::kNone;
  s_.status.state = api::ActionState::kError;
  s_.status.description = reason;
  brake(Brake::kSet);
}

/// Where the command leads the tool; none for commands that stop it.
void RobotController::update_goal() {
  switch (s_.status.kind) {
    case api::ActionKind::kGripperForce:
    case api::ActionKind::kOverride:
    case api::ActionKind::kMotionLimit:
      return;  // settings leave a motion alone
    case api::ActionKind::kMoveTo:
    case api::ActionKind::kMoveThroughTo:
    case api::ActionKind::kMoveScrew:
    case api::ActionKind::kMoveJoints:
      if (s_.has_next || s_.is_running) {
        const JointVector& end = s_.has_next ? s_.next.end() : s_.running.end();
        s_.X_RG = Pose::from(setup_.X_BR.inverse() * flange_pose(setup_.model, end) * X_FT());
        return;
      }
      break;
    default:
      break;
  }
  s_.X_RG.reset();
}

void RobotController::begin_task(Task task) {
  s_.task = task;
  s_.arrival_tolerance = {};
  s_.note.clear();
  if (!s_.held_error.empty()) return;
  s_.status.state = api::ActionState::kWorking;
  s_.status.description.clear();
}

void RobotController::complete_task() {
  s_.task = Task::kNone;
  if (!s_.held_error.empty()) return;
  s_.status.state = api::ActionState::kDone;
  s_.status.description = s_.note;
}

/// The motion has come to rest, or a joint in torque mode is in balance, which the description then
/// tells.
void RobotController::complete_motion() {
  complete_task();
  const int joint = s_.torque_mode.active() ? s_.torque_mode.balanced_joint() : -1;
  if (joint < 0 || !s_.held_error.empty()) return;
  char text[160];
  std::snprintf(text, sizeof text, "%s is held at %.2f deg by what it presses against",
                setup_.model.joints[static_cast<std::size_t>(joint)].name.c_str(),
                s_.reference(joint) * 180 / std::numbers::pi);
  s_.status.description.assign(text);  // within the capacity reserved at construction
}

bool RobotController::within_tolerance(const JointVector& q_actual) const {
  if (q_actual.size() == 0) return true;
  return has_arrived(s_.arrival_tolerance, setup_.model, setup_.X_BR.inverse(), X_FT(), q_actual,
                     s_.last_reference);
}

/// At rest. A changer that closes with nothing at the flange just closes.
void RobotController::change_tool(bool tool_at_flange) {
  const bool had = s_.tool_mounted;
  s_.tool_mounted = !s_.changer_open && (had || tool_at_flange);
  complete_task();
  if (!s_.changer_open && !s_.tool_mounted && s_.held_error.empty()) {
    s_.status.description.assign("nothing taken: the gripper is not at the flange");
  }
}

// ---- motion

JointVector RobotController::brake(Brake how) {
  s_.has_next = false;
  s_.to_joint_targets = false;
  s_.retreating = false;
  // Torque mode has no path to brake on.
  if (s_.torque_mode.active()) stop_at_once(s_.reference);
  if (!s_.is_running) return s_.reference;
  // A hard stop is not softened.
  const bool already = s_.braking && (*s_.braking == how || *s_.braking == Brake::kHard);
  if (!already) {
    s_.running.brake(arm(), how);
    s_.braking = how;
  }
  return s_.running.end();
}

/// Backward differences; the velocity is extrapolated by half a step to the reference itself.
JointState RobotController::reference_state() const {
  const double dt = setup_.step_s;
  const JointVector qdd =
      (s_.reference - 2 * s_.last_reference + s_.second_last_reference) / (dt * dt);
  return {s_.reference, (s_.reference - s_.last_reference) / dt + qdd * (dt / 2), qdd};
}

/// From `from`, which is the reference or the arm's actual posture, at the reference's velocity.
void RobotController::stop_at_once(const JointVector& from) {
  const bool torque_was_applied = s_.torque_mode.active();
  s_.has_next = false;
  s_.to_joint_targets = false;
  s_.retreating = false;
  s_.torque_mode.clear();
  // The history moves along, so that the reference's velocity stays.
  const JointVector shift = from - s_.reference;
  s_.reference = from;
  s_.last_reference += shift;
  s_.second_last_reference += shift;
  if (!s_.is_running && !torque_was_applied) return;
  planner_.plan_stop(reference_state(), s_.running);
  s_.is_running = true;
  s_.braking = Brake::kHard;
}

void RobotController::enqueue(const Result<void>& planned) {
  if (!planned) {
    set_error(planned.error().message);
    return;
  }
  switch_drives_on();
  s_.next.set_speed(s_.override_fraction);
  s_.has_next = true;
  begin_task(Task::kRest);
}

void RobotController::blend_from_running(const ToolLimits& tool) {
  if (!s_.is_running || !s_.has_next) return;
  if (!planner_.blend_from_motion(reference_state(), plan_start(s_.reference), tool, s_.next)) {
    return;
  }
  // The new motion replaces the running one, which need not come to rest.
  s_.next.set_speed(s_.override_fraction);
  std::swap(s_.running, s_.next);
  s_.has_next = false;
  s_.braking.reset();
}

/// Joints in torque mode begin at rest, together with the motion of the others where that is so.
void RobotController::start_torque_mode(const api::MoveJoints& move, const JointVector& from) {
  for (const api::JointTarget& target : move.targets) {
    if (!target.torque) continue;
    const auto i = static_cast<Eigen::Index>(target.joint);
    s_.torque_mode.add({target.joint,
                        std::clamp(target.position_rad, planner_.joint_limits().lower(i),
                                   planner_.joint_limits().upper(i)),
                        target.torque->setting_nm, target.torque->rate_nm_s.value_or(0)},
                       from(i));
  }
}

void RobotController::advance_motion() {
  s_.second_last_reference = s_.last_reference;
  s_.last_reference = s_.reference;
  if (s_.drive_power.braked()) return;
  // The next motion begins where the one before has come to rest.
  if (!s_.is_running && s_.has_next) {
    std::swap(s_.running, s_.next);
    s_.has_next = false;
    s_.is_running = true;
    s_.braking.reset();
  }
  if (!s_.is_running) return;
  if (s_.running.advance(arm(), setup_.step_s, s_.reference)) s_.is_running = false;
}

/// On top of the motion of the other joints.
void RobotController::advance_torque_mode(const JointVector& external_nm) {
  if (!s_.torque_mode.active() || s_.drive_power.braked()) return;
  if (s_.torque_mode_pending && (s_.is_running || s_.has_next)) return;
  s_.torque_mode_pending = false;
  const JointVector inertia =
      mass_matrix(setup_.model, setup_.payload, s_.last_reference).diagonal();
  s_.torque_mode.advance({.limits = planner_.joint_limits(),
                          .external_nm = external_nm,
                          .inertia = inertia,
                          .speed = s_.override_fraction,
                          .step_s = setup_.step_s},
                         s_.reference);
}

/// Straight in joint space to the newest posture of the trail that is far enough from `from`.
void RobotController::retreat(const JointVector& from) {
  const auto tool = [&](const JointVector& q) {
    return Eigen::Vector3d((flange_pose(setup_.model, q) * X_FT()).translation());
  };
  const Eigen::Vector3d here = tool(from);
  for (int age = 0; age < s_.retreat_trail.count(); ++age) {
    const JointVector& q = s_.retreat_trail.back(age);
    // The oldest posture is far enough in any case.
    const bool last = age + 1 == s_.retreat_trail.count();
    if (!last && (tool(q) - here).norm() < kRetreat_m &&
        (q - from).cwiseAbs().maxCoeff() < kRetreat_rad) {
      continue;
    }
    switch_drives_on();
    planner_.plan_retreat(from, q, s_.running);
    s_.is_running = s_.retreating = true;
    s_.braking.reset();
    break;
  }
  s_.retreat_trail.clear();
}

void RobotController::switch_drives_on() {
  s_.drive_power.switch_on(static_cast<int>(std::lround(kBrakeRelease_s / setup_.step_s)));
}

}  // namespace aprsim::robot
