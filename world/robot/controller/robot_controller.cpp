#include "world/robot/controller/robot_controller.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <utility>

#include "world/api/commands/beside_motion.hpp"
#include "world/robot/kinematics/dynamics.hpp"

namespace aprsim::robot {
namespace {

const char* const kNotInitialized = "not initialized: the robot must be initialized first";
const char* const kNoTool =
    "no tool is on the robot: close the tool changer where one is, within its capture range";
const char* const kNothingTaken = "nothing taken: no tool is at the flange";
const char* const kTooManyHeld =
    "too many commands wait for the tool changer: at most 16, send InitCanon";
constexpr std::size_t kMostHeld = 16;
const char* const kMoveBefore = "the move before: ";
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
  if (setup.tools.empty()) setup.tools.push_back({setup.X_FT, setup.payload});
  return setup;
}

/// One for each tool, and one without.
std::vector<MotionPlanner> planners_of(const ControllerSetup& setup) {
  std::vector<MotionPlanner> planners;
  const auto add = [&](const Payload& payload) {
    planners.emplace_back(
        PlannerSetup{setup.model, setup.ik, setup.X_BR, payload, setup.gravity_B});
  };
  for (const ToolSetup& tool : setup.tools) add(tool.payload);
  add(setup.payload_open);
  return planners;
}

/// What is done even while the tool changer works.
bool comes_first(const api::RobotAction& action) {
  return std::holds_alternative<api::InitRobot>(action) ||
         std::holds_alternative<api::EndRobot>(action) ||
         std::holds_alternative<api::StopMotion>(action);
}

ToolLimits tool_maximum(const ControllerSetup& setup) {
  return {setup.max_trans_speed_m_s, setup.max_trans_accel_m_s2, setup.max_rot_speed_rad_s,
          setup.max_rot_accel_rad_s2};
}

constexpr double kServoResolution = 1e-6;  ///< of the servo [m, rad]

bool within(const std::optional<double>& tolerance, double deviation) {
  return !tolerance || std::abs(deviation) <= std::max(*tolerance, kServoResolution);
}

/// Whether the arm at `q` is within tolerance of `target`. Poses are those of the tool in R.
/// Tolerances below the servo's resolution (1 um, 1 urad) count as that.
bool has_arrived(const ArrivalTolerance& tolerance, const ArmModel& model,
                 const Eigen::Isometry3d& X_RB, const Eigen::Isometry3d& X_FT, const JointVector& q,
                 const JointVector& target) {
  // The common case: nothing pushes the arm aside.
  if (q == target) return true;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    if (!within(tolerance.joint_rad[static_cast<std::size_t>(i)], q(i) - target(i))) return false;
  }
  // Deviation of the tool in R: of its position, and of its x and z axis (CRCL's
  // PoseToleranceType).
  const api::PoseTolerance& pose = tolerance.pose;
  const bool any = pose.x_m || pose.y_m || pose.z_m || pose.x_axis_rad || pose.z_axis_rad;
  if (!any) return true;
  const Eigen::Isometry3d X_RT = X_RB * flange_pose(model, q) * X_FT;
  const Eigen::Isometry3d X_RT_target = X_RB * flange_pose(model, target) * X_FT;
  const Eigen::Vector3d off = X_RT.translation() - X_RT_target.translation();
  const auto axis_off = [&](int axis) {
    return angle_between(X_RT.linear().col(axis), X_RT_target.linear().col(axis));
  };
  return within(pose.x_m, off.x()) && within(pose.y_m, off.y()) && within(pose.z_m, off.z()) &&
         within(pose.x_axis_rad, axis_off(0)) && within(pose.z_axis_rad, axis_off(2));
}

}  // namespace

RobotController::RobotController(ControllerSetup setup)
    : setup_(checked(std::move(setup))),
      planners_(planners_of(setup_)),
      s_(tool_maximum(setup_), setup_.q_home) {
  s_.tool = setup_.tool;
  s_.held.reserve(kMostHeld);
  s_.status.description.reserve(kReasonCapacity);
  s_.note.reserve(kReasonCapacity);
}

void RobotController::apply(api::Ticket ticket, const api::RobotAction& action,
                            const JointVector& q_actual) {
  if (comes_first(action)) {
    drop_held();
  } else if (s_.changer != Changer::kIdle && s_.held_error.empty()) {
    return hold(ticket, action);
  }
  run(ticket, action, q_actual);
}

void RobotController::run(api::Ticket ticket, const api::RobotAction& action,
                          const JointVector& q_actual) {
  s_.status.ticket = ticket;
  s_.status.kind = api::kind_of(action);
  std::visit([&](const auto& command) { execute(command, q_actual); }, action);
  // What is done beside a motion leaves it alone, and so does a move until it begins.
  if (api::is_move(action)) {
    if (!s_.planning) update_goal();
  } else if (!api::leaves_motion(action)) {
    s_.X_RG.reset();
  }
}

const JointVector& RobotController::step(const ControllerInput& input) {
  if (s_.planning && s_.planning_steps-- == 0) {
    begin_planned();
    if (s_.planning) --s_.planning_steps;  // of the next plan this step is the first
  }
  // The reference of this step.
  s_.drive_power.step(at_rest());
  s_.runner.advance(arm(), setup_.step_s, s_.drive_power.braked());
  advance_torque_mode(input.external_nm);
  s_.retreat_trail.record(reference());
  advance_changer(input.tool_at_flange);
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
      if (s_.gripper_applied && (input.gripper_settled || s_.steps_left <= 0)) complete_task();
      s_.gripper_applied = true;
      break;
    case Task::kToolChanger:  // by advance_changer()
      break;
    case Task::kDwell:
      if (--s_.steps_left <= 0) complete_task();
      break;
  }
  return reference();
}

void RobotController::protective_stop(const std::string& reason, const JointVector& q_actual) {
  // The reference stands still where the arm is.
  cancel_planning();
  s_.to_joint_targets = false;
  s_.torque_mode.clear();
  s_.runner.stand_at(q_actual);
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

void RobotController::shut_down(const std::string& reason, bool on_path) {
  // The hardest braking comes first: set_error() then finds nothing left to brake.
  if (on_path) {
    brake(Brake::kHard);
  } else {
    stop_at_once(reference());
  }
  set_error(reason);
  s_.drive_power.switch_off_after(0);
}

void RobotController::refuse(api::Ticket ticket, const api::RobotAction& action,
                             const std::string& reason) {
  s_.status.ticket = ticket;
  s_.status.kind = api::kind_of(action);
  s_.status.state = api::ActionState::kError;
  s_.status.description = reason;
  s_.held_error = reason;
  s_.initialized = false;
  s_.task = Task::kNone;
}

void RobotController::slow_down(double share) {
  s_.speed_share = share;
  s_.runner.set_speed(speed(), s_.protection);
}

std::optional<Pose> RobotController::X_RG() const {
  return moving() && s_.held_error.empty() ? s_.X_RG : std::nullopt;
}

Eigen::Isometry3d RobotController::X_FT() const {
  return s_.tool >= 0 ? setup_.tools[static_cast<std::size_t>(s_.tool)].X_FT : setup_.X_FT_open;
}

const MotionPlanner& RobotController::planner() const {
  return s_.tool >= 0 ? planners_[static_cast<std::size_t>(s_.tool)] : planners_.back();
}

const Payload& RobotController::payload() const {
  return s_.tool >= 0 ? setup_.tools[static_cast<std::size_t>(s_.tool)].payload
                      : setup_.payload_open;
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
      stop_at_once(reference());
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

void RobotController::execute(const api::MoveTo& move, const JointVector&) { request(move); }

void RobotController::execute(const api::MoveThroughTo& move, const JointVector&) { request(move); }

void RobotController::execute(const api::MoveScrew& screw, const JointVector&) { request(screw); }

void RobotController::execute(const api::MoveJoints& move, const JointVector&) { request(move); }

void RobotController::execute(const api::SetGripper& gripper, const JointVector&) {
  if (!require_initialized()) return;
  if (s_.tool < 0) {
    set_error(kNoTool);
    return;
  }
  // The deadline is for a gripper that reports nothing.
  s_.gripper_setting = gripper.setting;
  s_.gripper_applied = false;
  s_.steps_left = std::llround(kGripperDeadline_s / setup_.step_s);
  begin_task(Task::kGripper);
}

void RobotController::execute(const api::SetToolChanger& changer, const JointVector&) {
  if (!require_initialized()) return;
  brake(Brake::kSet);
  s_.changer_open = changer.open;
  s_.changer = Changer::kWaits;
  s_.changer_steps = std::llround(setup_.tool_change_s / setup_.step_s);
  begin_task(Task::kToolChanger);
}

/// The force itself is SimulatedRobot's.
void RobotController::execute(const api::SetGripperForce&, const JointVector&) { complete_task(); }

void RobotController::execute(const api::SetOverride& setting, const JointVector&) {
  // It applies to the running motion, but not to the braking of a protective stop.
  s_.override_fraction = setting.fraction;
  s_.runner.set_speed(speed(), s_.protection);
  complete_task();
}

void RobotController::execute(const api::Dwell& dwell, const JointVector&) {
  if (!require_initialized()) return;
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
  drop_held();
  s_.task = Task::kNone;
  s_.status.state = api::ActionState::kError;
  s_.status.description = reason;
  brake(Brake::kSet);
}

void RobotController::update_goal() {
  s_.X_RG.reset();
  if (s_.runner.idle()) return;
  s_.X_RG = Pose::from(setup_.X_BR.inverse() * flange_pose(setup_.model, s_.runner.end()) * X_FT());
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
                reference()(joint) * 180 / std::numbers::pi);
  s_.status.description.assign(text);  // within the capacity reserved at construction
}

bool RobotController::within_tolerance(const JointVector& q_actual) const {
  if (q_actual.size() == 0) return true;
  return has_arrived(s_.arrival_tolerance, setup_.model, setup_.X_BR.inverse(), X_FT(), q_actual,
                     s_.runner.last_reference());
}

// ---- tool changer

/// At rest. What the lock meets at its end position is what it takes; closed on nothing it takes
/// nothing, and a tool that it has already it keeps.
void RobotController::advance_changer(int tool_at_flange) {
  if (s_.changer == Changer::kWaits && at_rest()) s_.changer = Changer::kWorks;
  if (s_.changer != Changer::kWorks || s_.changer_steps-- > 0) return;
  s_.changer = Changer::kIdle;
  if (s_.changer_open) {
    s_.tool = -1;
  } else if (s_.tool < 0) {
    s_.tool = tool_at_flange;
  }
  if (s_.task == Task::kToolChanger) {
    complete_task();
    if (!s_.changer_open && s_.tool < 0 && s_.held_error.empty()) {
      s_.status.description.assign(kNothingTaken);
    }
  }
  run_held();
}

/// The status is that of the latest command.
void RobotController::hold(api::Ticket ticket, const api::RobotAction& action) {
  s_.status.ticket = ticket;
  s_.status.kind = api::kind_of(action);
  if (s_.held.size() == kMostHeld) return set_error(kTooManyHeld);
  s_.held.push_back({ticket, action});
  s_.status.state = api::ActionState::kWorking;
  s_.status.description.clear();
}

/// Up to the next one for the changer, one after the other as if they came now.
void RobotController::run_held() {
  if (s_.held.empty()) return;
  const api::Ticket latest = s_.held.back().ticket;
  const api::ActionKind kind = api::kind_of(s_.held.back().action);
  std::size_t done = 0;
  while (done < s_.held.size() && s_.changer == Changer::kIdle) {
    const HeldCommand next = std::move(s_.held[done++]);
    run(next.ticket, next.action, reference());
    if (s_.held.empty()) return;  // after an error
  }
  s_.held.erase(s_.held.begin(), s_.held.begin() + static_cast<std::ptrdiff_t>(done));
  if (s_.held.empty()) return;
  s_.status.ticket = latest;
  s_.status.kind = kind;
}

/// A valve that is switched stays so.
void RobotController::drop_held() {
  s_.held.clear();
  if (s_.changer == Changer::kWaits) s_.changer = Changer::kIdle;
}

// ---- motion

void RobotController::brake(Brake how) {
  cancel_planning();
  s_.to_joint_targets = false;
  s_.retreating = false;
  // Torque mode has no path to brake on.
  if (s_.torque_mode.active()) stop_at_once(reference());
  s_.runner.brake(arm(), how);
}

/// From `from`, which is the reference or the arm's actual posture, at the reference's velocity.
void RobotController::stop_at_once(const JointVector& from) {
  const bool moves = s_.runner.running() || s_.torque_mode.active();
  cancel_planning();
  s_.to_joint_targets = false;
  s_.retreating = false;
  s_.torque_mode.clear();
  s_.runner.drop_next();
  s_.runner.shift_to(from);
  if (!moves) return;
  const JointState state = s_.runner.state(setup_.step_s);
  s_.runner.replace(MotionSequence(planner().plan_stop(state)), Brake::kHard);
}

// ---- planning

void RobotController::cancel_planning() {
  s_.waiting.reset();
  if (!s_.planning) return;
  s_.planning->cancel();
  s_.planning.reset();
}

/// By what the command says alone, so that it is the same on any machine.
int RobotController::planning_steps(const PlannedMove& move, bool search) const {
  double latency_s = setup_.latency.base_s;
  if (const auto* through = std::get_if<api::MoveThroughTo>(&move)) {
    latency_s += setup_.latency.waypoint_s * static_cast<double>(through->waypoints.size());
  }
  if (std::holds_alternative<api::MoveScrew>(move)) latency_s += setup_.latency.screw_s;
  if (search) latency_s += setup_.latency.search_s;
  return static_cast<int>(std::lround(latency_s / setup_.step_s));
}

void RobotController::request(PlannedMove move) {
  if (!require_initialized()) return;
  begin_task(Task::kRest);
  MoveRequest request{std::move(move), X_FT(), s_.tool_limits};
  // A plan that is nearly ready is waited for, so that moves in quick succession do move the arm;
  // one that takes longer than the new one is given up, but for a search: the new move may need one
  // as well.
  if (s_.planning &&
      (s_.planning->request().search || s_.planning_steps <= planning_steps(request.move, false))) {
    s_.waiting = std::move(request);
    return;
  }
  begin_planning(std::move(request));
}

void RobotController::begin_planning(MoveRequest request, bool search) {
  cancel_planning();
  // Joints that the command does not name keep the targets of the move that it replaces.
  const bool keep_targets = s_.to_joint_targets && !s_.runner.idle();
  // Torque mode ends now: what it meets cannot be foreseen.
  s_.torque_mode_pending = s_.torque_mode.active();
  if (s_.torque_mode.active()) stop_at_once(reference());
  PlanRequest job{.request = std::move(request),
                  .step_s = setup_.step_s,
                  .runner = s_.runner,
                  .drive_power = s_.drive_power};
  job.search = search;
  job.steps = planning_steps(job.request.move, search);
  if (keep_targets) job.joint_targets = s_.joint_targets;
  s_.planning_steps = job.steps;
  s_.planning = std::make_shared<PlanJob>(planner(), std::move(job));
  if (s_.planning_steps == 0) {
    begin_planned();
  } else if (setup_.prefetcher != nullptr) {
    setup_.prefetcher->prefetch(s_.planning);
  }
}

/// The move that waits, or the planned one.
MoveRequest RobotController::take_latest(const PlanJob& planned) {
  return s_.waiting ? *std::exchange(s_.waiting, std::nullopt) : planned.request().request;
}

void RobotController::begin_planned() {
  if (setup_.prefetcher != nullptr && !s_.planning->ready()) ++plan_waits_;
  const std::shared_ptr<PlanJob> job = std::exchange(s_.planning, nullptr);
  const Plan& plan = job->get();
  const PlannedMove& move = job->request().request.move;
  // The motion that runs may have been changed meanwhile: planned again from where it is now.
  MotionRunner braked = s_.runner;
  const JointVector rest = braked.brake(arm(), Brake::kSet);
  const JointState state = s_.runner.state(setup_.step_s);
  const bool foreseen = plan.rest == rest && plan.state.q == state.q && plan.state.qd == state.qd &&
                        plan.state.qdd == state.qdd;
  if (!foreseen) {
    return begin_planning(take_latest(*job));
  }
  if (plan.search_wanted) return begin_planning(take_latest(*job), true);
  if (plan.outcome) {
    begin_motion(move, plan);
  } else if (!s_.waiting) {
    // The latest command may be one beside the move.
    const std::string& reason = plan.outcome.error().message;
    set_error(s_.task == Task::kRest ? reason : std::string(kMoveBefore) + reason);
  }
  if (s_.waiting) begin_planning(*std::exchange(s_.waiting, std::nullopt));
}

void RobotController::begin_motion(const PlannedMove& move, const Plan& plan) {
  const auto* joints = std::get_if<api::MoveJoints>(&move);
  if (joints) s_.torque_mode_pending = s_.torque_mode_pending || s_.runner.running();
  s_.retreating = false;
  switch_drives_on();
  MotionSequence next = plan.blended ? MotionSequence(*plan.blended) : MotionSequence(plan.motions);
  next.set_speed(speed());
  if (plan.blended) {
    s_.runner.replace(std::move(next));
  } else {
    s_.runner.brake(arm(), Brake::kSet);
    s_.runner.queue(std::move(next));
  }
  s_.to_joint_targets = joints != nullptr;
  if (joints) {
    s_.joint_targets = plan.joint_targets;
    start_torque_mode(*joints, plan);
  }
  set_tolerance(move);
  update_goal();
}

void RobotController::set_tolerance(const PlannedMove& move) {
  s_.arrival_tolerance = {};
  if (const auto* to = std::get_if<api::MoveTo>(&move)) {
    s_.arrival_tolerance.pose = to->tolerance;
  } else if (const auto* through = std::get_if<api::MoveThroughTo>(&move)) {
    s_.arrival_tolerance.pose = through->waypoints.back().tolerance;
  } else if (const auto* joints = std::get_if<api::MoveJoints>(&move)) {
    for (const api::JointTarget& target : joints->targets) {
      if (!target.tolerance_rad || target.torque) continue;
      s_.arrival_tolerance.joint_rad[static_cast<std::size_t>(target.joint)] =
          *target.tolerance_rad;
    }
  }
}

ControllerState RobotController::save() const {
  ControllerState state = s_;
  // The plan that is being made is not kept: it would come later, with its memory.
  if (state.planning) state.planning = state.planning->unmade();
  return state;
}

void RobotController::restore(const ControllerState& state) {
  s_ = state;
  if (!s_.planning) return;
  // Whoever else has the job may cancel it.
  s_.planning = std::make_shared<PlanJob>(planner(), s_.planning->request());
  if (setup_.prefetcher != nullptr) setup_.prefetcher->prefetch(s_.planning);
}

// ---- motion

/// Joints in torque mode begin at rest, together with the motion of the others where that is so.
void RobotController::start_torque_mode(const api::MoveJoints& move, const Plan& plan) {
  for (const api::JointTarget& target : move.targets) {
    if (!target.torque) continue;
    const auto i = static_cast<Eigen::Index>(target.joint);
    s_.torque_mode.add(
        {target.joint,
         std::clamp(position_of(target, plan.held), planner().joint_limits().lower(i),
                    planner().joint_limits().upper(i)),
         target.torque->setting_nm, target.torque->rate_nm_s.value_or(0)},
        plan.rest(i));
  }
}

/// On top of the motion of the other joints.
void RobotController::advance_torque_mode(const JointVector& external_nm) {
  if (!s_.torque_mode.active() || s_.drive_power.braked()) return;
  if (s_.torque_mode_pending && !s_.runner.idle()) return;
  s_.torque_mode_pending = false;
  const JointVector inertia =
      mass_matrix(setup_.model, payload(), s_.runner.last_reference()).diagonal();
  s_.torque_mode.advance({.limits = planner().joint_limits(),
                          .external_nm = external_nm,
                          .inertia = inertia,
                          .speed = speed(),
                          .step_s = setup_.step_s},
                         s_.runner.reference());
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
    s_.runner.replace(MotionSequence(planner().plan_retreat(from, q)));
    s_.retreating = true;
    break;
  }
  s_.retreat_trail.clear();
}

void RobotController::switch_drives_on() {
  s_.drive_power.switch_on(static_cast<int>(std::lround(kBrakeRelease_s / setup_.step_s)));
}

}  // namespace aprsim::robot
