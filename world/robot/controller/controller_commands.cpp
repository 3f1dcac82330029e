#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "world/robot/controller/controller_core.hpp"

// What each command does to a robot controller.

namespace aprsim::robot {
namespace {

constexpr double kGripperDeadline_s = 2;
constexpr double kDrivesOffAfterFastStop_s = 1;
/// An estimate: what holding brakes of servo motors of this size take to release.
constexpr double kBrakeRelease_s = 0.1;
const char* const kNoTool =
    "the gripper is not on the robot: the tool changer is open; close it where the gripper is";

}  // namespace

void RobotController::Core::execute(const api::InitRobot&, const JointVector& q_actual) {
  s.held_error.clear();
  s.protection = false;
  s.initialized = true;
  switch_drives_on();
  const bool leaving = s.backing_off && s.is_running;  // what it has hit: that comes first
  if (!leaving) stop_at_once(q_actual);
  working(Task::kRest);
}

void RobotController::Core::execute(const api::EndRobot&, const JointVector&) {
  s.initialized = false;
  brake(Brake::kSet);
  working(Task::kRest);
}

void RobotController::Core::execute(const api::StopMotion& stop, const JointVector&) {
  switch (stop.kind) {
    case api::StopKind::kImmediate:
      stop_at_once(s.reference);
      s.drives.switch_off_after(0);
      break;
    case api::StopKind::kFast:
      brake(Brake::kHard);
      s.drives.switch_off_after(
          static_cast<int>(std::lround(kDrivesOffAfterFastStop_s / setup.step_s)));
      break;
    case api::StopKind::kNormal:
      brake(Brake::kSet);
      s.drives.keep();
      break;
  }
  working(Task::kRest);
}

void RobotController::Core::switch_drives_on() {
  s.drives.switch_on(static_cast<int>(std::lround(kBrakeRelease_s / setup.step_s)));
}

void RobotController::Core::execute(const api::MoveTo& move, const JointVector&) {
  if (!ready()) return;
  const JointVector from = brake(Brake::kSet);
  start(planner.plan(move, plan_start(from), s.limits, s.next));
  s.arrival.pose = move.tolerance;
  if (!move.straight) start_in_passing(s.limits.effective(move.limits));
}

void RobotController::Core::execute(const api::MoveThroughTo& move, const JointVector&) {
  if (!ready()) return;
  const JointVector from = brake(Brake::kSet);
  start(planner.plan(move, plan_start(from), s.limits, s.next));
  if (!move.waypoints.empty()) s.arrival.pose = move.waypoints.back().tolerance;
}

void RobotController::Core::execute(const api::MoveScrew& screw, const JointVector&) {
  if (!ready()) return;
  const JointVector from = brake(Brake::kSet);
  start(planner.plan(screw, plan_start(from), s.limits, s.next));
}

void RobotController::Core::execute(const api::MoveJoints& move, const JointVector&) {
  if (!ready()) return;
  s.torque_waits = s.is_running || s.torque.active();
  const bool keep_targets = (s.is_running || s.has_next) && s.joint_move;
  const JointVector from = brake(Brake::kSet);
  if (!keep_targets) s.joint_targets = from;
  start(planner.plan(move, plan_start(from), s.limits, s.joint_targets, s.next));
  s.joint_move = s.has_next;
  for (const api::JointTarget& target : move.targets) {
    if (!target.tolerance_rad || target.torque) continue;
    s.arrival.joint_rad[static_cast<std::size_t>(target.joint)] = *target.tolerance_rad;
  }
  if (!s.has_next) return;
  start_in_passing(s.limits.maximum());
  drive_by_torque(move, from);
}

/// Joints that press begin at rest, together with the motion of the others where that is so.
void RobotController::Core::drive_by_torque(const api::MoveJoints& move, const JointVector& from) {
  for (const api::JointTarget& target : move.targets) {
    if (!target.torque) continue;
    const auto i = static_cast<Eigen::Index>(target.joint);
    s.torque.add({target.joint,
                  std::clamp(target.position_rad, planner.joint_limits().lower(i),
                             planner.joint_limits().upper(i)),
                  target.torque->setting_nm, target.torque->rate_nm_s.value_or(0)},
                 from(i));
  }
}

/// The motion has come to rest, or a joint that presses is in balance.
void RobotController::Core::arrived() {
  done();
  const int joint = s.torque.active() ? s.torque.balanced_joint() : -1;
  if (joint < 0 || !s.held_error.empty()) return;
  char text[160];
  std::snprintf(text, sizeof text, "%s is held at %.2f deg by what it presses against",
                setup.model.joints[static_cast<std::size_t>(joint)].name.c_str(),
                s.reference(joint) * 180 / std::numbers::pi);
  s.status.description.assign(text);  // within the capacity reserved at construction
}

void RobotController::Core::execute(const api::SetGripper& gripper, const JointVector&) {
  if (!ready()) return;
  if (!s.tool_mounted) {
    set_error(kNoTool);
    return;
  }
  if (!(gripper.setting >= 0 && gripper.setting <= 1)) {
    char text[96];
    std::snprintf(text, sizeof text, "gripper setting %g is outside its limits 0 to 1",
                  gripper.setting);
    set_error(text);
    return;
  }
  brake(Brake::kSet);
  s.gripper_setting = gripper.setting;
  s.gripper_applied = false;
  s.steps_left = std::llround(kGripperDeadline_s / setup.step_s);
  working(Task::kGripper);
}

void RobotController::Core::execute(const api::SetToolChanger& changer, const JointVector&) {
  if (!ready()) return;
  brake(Brake::kSet);
  s.changer_open = changer.open;
  working(Task::kToolChanger);
}

/// At rest. A changer that closes with nothing at the flange just closes.
void RobotController::Core::change_tool(bool tool_at_flange) {
  const bool had = s.tool_mounted;
  s.tool_mounted = !s.changer_open && (had || tool_at_flange);
  done();
  if (!s.changer_open && !s.tool_mounted && s.held_error.empty()) {
    s.status.description.assign("nothing taken: the gripper is not at the flange");
  }
}

/// The gripper's own business: see SimulatedRobot.
void RobotController::Core::execute(const api::SetGripperForce&, const JointVector&) { done(); }

void RobotController::Core::execute(const api::SetOverride& setting, const JointVector&) {
  if (!(setting.fraction >= 0 && setting.fraction <= 1)) {
    char text[96];
    std::snprintf(text, sizeof text, "speed override %g %% is outside its limits 0 to 100 %%",
                  setting.fraction * 100);
    if (s.held_error.empty()) set_error(text);
    return;
  }
  s.override_fraction = setting.fraction;
  if (s.is_running && !s.protection) s.running.set_speed(setting.fraction);
  if (s.has_next) s.next.set_speed(setting.fraction);
  done();
}

void RobotController::Core::execute(const api::Dwell& dwell, const JointVector&) {
  if (!ready()) return;
  if (dwell.duration < SimTime::zero()) {
    char text[96];
    std::snprintf(text, sizeof text, "dwell time %g s is less than its limit 0 s",
                  seconds(dwell.duration));
    set_error(text);
    return;
  }
  brake(Brake::kSet);
  const std::int64_t step_ns = std::llround(setup.step_s * 1e9);
  const std::int64_t whole = dwell.duration.count() / step_ns;
  s.steps_left = whole + (dwell.duration.count() % step_ns != 0 ? 1 : 0);
  working(Task::kDwell);
}

void RobotController::Core::execute(const api::SetMotionLimit& setting, const JointVector&) {
  if (const auto ok = s.limits.set(setting); !ok) {
    if (s.held_error.empty()) set_error(ok.error().message);
    return;
  }
  done();
}

}  // namespace aprsim::robot
