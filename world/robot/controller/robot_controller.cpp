#include "world/robot/controller/robot_controller.hpp"

#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>

#include "world/api/commands/concurrent_action.hpp"
#include "world/robot/kinematics/dynamics.hpp"

namespace aprsim::robot {
namespace {

const char* const kNotInitialized = "not initialized: the robot must be initialized first";
const char* const kNoTool =
    "no tool is on the robot: close the tool changer where one is, within its capture range";
const char* const kNothingTaken = "nothing taken: no tool is at the flange";
const char* const kTooManyDeferred =
    "too many commands wait for the tool changer: at most 16, send InitCanon";
const char* const kHasTheRobot = " has the robot by a stream of motions; StopMotion ends it";
const char* const kBusyChanger = "busy: the tool changer works";
const char* const kMoveBefore = "the move before: ";
/// Whether a move is not to be checked.
bool may_touch(const PlannedMove& move) {
  if (const auto* to = std::get_if<api::MoveTo>(&move)) return to->may_touch;
  const auto* joints = std::get_if<api::MoveJoints>(&move);
  return joints != nullptr && joints->may_touch;
}

constexpr double kGripperDeadline_s = 2;
constexpr double kDrivesOffAfterFastStop_s = 1;
/// A move that had to be planned so often because other robots began to move is refused.
constexpr int kMostReplans = 16;
const char* const kOthersMove =
    "planning: other robots begin one motion after the other; send the move again";

}  // namespace

RobotController::RobotController(ControllerSetup setup)
    : setup_(checked(std::move(setup))),
      arms_(equipped_arms(setup_)),
      s_(tool_maximum(setup_), setup_.q_home, setup_.tool) {
  s_.planning = setup_.planning;
}

// ---- commands

void RobotController::apply(api::Ticket ticket, const api::RobotAction& action,
                            const JointVector& q_actual) {
  if (refuse_as_busy(ticket, action)) return;
  // Stops and initialisation act at once and drop deferred commands; everything else waits for the
  // lock.
  if (precedes_tool_change(action)) {
    s_.changer.cancel();
  } else if (s_.changer.busy() && !s_.command.in_error()) {
    return defer(ticket, action);
  }
  run(ticket, action, q_actual);
}

void RobotController::run(api::Ticket ticket, const api::RobotAction& action,
                          const JointVector& q_actual) {
  s_.command.accept(ticket, api::kind_of(action));
  std::visit([&](const auto& command) { execute(command, q_actual); }, action);
  // A concurrent action does not change the goal of the motion, and neither does a move before it
  // begins.
  if (api::is_move(action)) {
    if (!s_.plans.planning()) update_goal();
  } else if (!api::leaves_motion(action)) {
    s_.X_RG.reset();
  }
}

void RobotController::execute(const api::InitRobot&, const JointVector& q_actual) {
  reset(q_actual);
  begin_task(Task::kRest);
}

/// Clears errors and makes the actual posture the reference.
void RobotController::reset(const JointVector& q_actual) {
  s_.command.initialize();
  s_.protection = false;
  s_.stream.clear_alarm();
  s_.motion.switch_drives_on(setup_.step_s);
  // Initialising during the retreat must not leave the arm in contact.
  // A retreat from a collision comes first.
  if (!retreating()) stop_from(q_actual);
}

void RobotController::execute(const api::EndProgram&, const JointVector&) {
  // A client that leaves does not stop the motion of another one.
  if (s_.stream.active()) return s_.command.complete();
  brake(Brake::kSet);
  begin_task(Task::kRest);
}

void RobotController::execute(const api::StopMotion& stop, const JointVector&) {
  switch (stop.kind) {
    // CRCL StopConditionEnumType: immediate leaves the path, fast and normal stay on it.
    case api::StopKind::kImmediate:
      stop_from(reference());
      s_.motion.switch_drives_off_after(0);
      break;
    case api::StopKind::kFast:
      brake(Brake::kHard);
      s_.motion.switch_drives_off_after(
          static_cast<int>(std::lround(kDrivesOffAfterFastStop_s / setup_.step_s)));
      break;
    case api::StopKind::kNormal:
      brake(Brake::kSet);
      s_.motion.keep_drives_on();
      break;
  }
  // The motion's points are dropped by now.
  s_.stream.stopped("stopped by StopMotion", s_.motion);
  begin_task(Task::kRest);
}

void RobotController::execute(const api::SetGripper& gripper, const JointVector&) {
  if (!require_initialized()) return;
  if (tool() < 0) return fail(kNoTool);
  // The deadline is for a gripper that reports nothing.
  s_.gripper_setting = gripper.setting;
  s_.gripper_applied = false;
  s_.steps_left = std::llround(kGripperDeadline_s / setup_.step_s);
  begin_task(Task::kGripper);
}

void RobotController::execute(const api::SetToolChanger& changer, const JointVector&) {
  if (!require_initialized()) return;
  brake(Brake::kSet);
  s_.changer.begin(changer.open, std::llround(setup_.tool_change_s / setup_.step_s));
  begin_task(Task::kToolChanger);
}

void RobotController::execute(const api::SetOverride& setting, const JointVector&) {
  // It applies to the running motion, but not to the braking of a protective stop.
  s_.motion.set_override(setting.fraction, s_.protection);
  s_.command.complete();
}

void RobotController::execute(const api::Dwell& dwell, const JointVector&) {
  if (!require_initialized()) return;
  // Whole steps, rounded up.
  // Integer nanoseconds: a division of doubles could add a step.
  const std::int64_t step_ns = std::llround(setup_.step_s * 1e9);
  const std::int64_t whole = dwell.duration.count() / step_ns;
  s_.steps_left = whole + (dwell.duration.count() % step_ns != 0 ? 1 : 0);
  begin_task(Task::kDwell);
}

void RobotController::execute(const api::SetMotionLimit& setting, const JointVector&) {
  s_.tool_limits.set(setting);
  s_.command.complete();
}

void RobotController::execute(const api::SetPlanning& setting, const JointVector&) {
  s_.planning = setting.mode;
  s_.command.complete();
}

// ---- streams

/// Refuses a command that would disturb the stream's commander.
bool RobotController::refuse_as_busy(api::Ticket ticket, const api::RobotAction& action) {
  if (!s_.stream.active()) return false;
  const bool disturbs = api::is_move(action) || std::holds_alternative<api::InitRobot>(action) ||
                        std::holds_alternative<api::SetToolChanger>(action);
  if (!disturbs) return false;
  refuse(ticket, action, "busy: " + s_.stream.commander() + kHasTheRobot);
  return true;
}

/// Whether a stream can begin.
Result<void> RobotController::require_free() const {
  const auto busy = [](const std::string& message) {
    return aprsim::fail(ErrorCode::kFailedPrecondition, "commander", message);
  };
  if (s_.stream.active()) return busy("busy: " + s_.stream.commander() + kHasTheRobot);
  if (!s_.stream.alarm().empty()) {
    return aprsim::fail(ErrorCode::kFailedPrecondition, "alarm", "alarm: " + s_.stream.alarm());
  }
  if (s_.changer.busy()) return busy(kBusyChanger);
  if (!at_rest()) return busy("busy: a command moves the robot, or a stop is under way");
  return {};
}

Result<void> RobotController::claim(api::Ticket ticket, const api::ClaimMotion& command,
                                    const JointVector& q_actual) {
  if (command.takes_over != 0 && s_.stream.number() == command.takes_over) {
    stop_from(reference());
    s_.stream.stopped("taken over by " + command.commander, s_.motion);
  }
  // A reset while another commander moves the robot would stop it.
  if (command.reset && !s_.stream.active() && !s_.changer.busy() && at_rest()) reset(q_actual);
  if (auto ok = require_free(); !ok) return ok;
  s_.stream.claim(ticket, command, stream_arm());
  ++s_.motions_begun;
  return {};
}

Result<void> RobotController::follow(api::Ticket ticket, const api::FollowTrajectory& command,
                                     std::int64_t delay, const JointVector& q_actual) {
  if (command.reset && !s_.stream.active() && at_rest()) reset(q_actual);
  if (auto ok = require_free(); !ok) return ok;
  ++s_.motions_begun;
  return s_.stream.follow(ticket, command, delay, stream_arm());
}

Result<void> RobotController::apply(api::Ticket ticket, const api::TrajectoryAction& action,
                                    std::int64_t delay, const JointVector& q_actual) {
  return std::visit(
      [&](const auto& command) -> Result<void> {
        using Command = std::decay_t<decltype(command)>;
        if constexpr (std::is_same_v<Command, api::ClaimMotion>) {
          return claim(ticket, command, q_actual);
        } else if constexpr (std::is_same_v<Command, api::FollowTrajectory>) {
          return follow(ticket, command, delay, q_actual);
        } else if constexpr (std::is_same_v<Command, api::SwitchGripper>) {
          s_.gripper_setting = command.setting;
          s_.gripper_applied = false;
          return {};
        } else {
          return s_.stream.apply(command, stream_arm());
        }
      },
      action);
}

void RobotController::write(api::MotionSnapshot& out) const {
  s_.stream.write(s_.motion, setup_.step_s, out);
  if (s_.stream.active()) return;
  const bool commanded = !at_rest() || s_.changer.busy();
  out.source = commanded ? api::MotionSource::kCommands : api::MotionSource::kNone;
}

// ---- one step

const JointVector& RobotController::step(const ControllerInput& input) {
  if (s_.stream.active()) s_.stream.step(input.q_actual, input.qd_actual, stream_arm());
  if (s_.plans.step()) {
    begin_planned();
    s_.plans.step();  // this step is also the first of the next plan
  }
  s_.motion.step(arm(), input.external_nm, s_.plans.planning());
  // The tool changer needs the arm at rest after this step's motion, so that it comes after it.
  if (s_.changer.step(at_rest(), input.tool_at_flange)) finish_tool_change();
  check_completion(input);
  return reference();
}

// ---- planning

/// Plans the move now, or after the plan in progress.
void RobotController::plan(PlannedMove move) {
  if (!require_initialized()) return;
  begin_task(Task::kRest);
  const int steps = latency_steps(move, false);
  MoveRequest request{std::move(move), X_FT(), s_.tool_limits};
  if (s_.plans.waits(steps)) {
    // Only one move waits: each newer one replaces it, as it would replace a running one.
    s_.plans.wait(std::move(request));
  } else {
    begin_planning(std::move(request));
  }
}

void RobotController::begin_planning(MoveRequest move, bool search, int replans) {
  s_.plans.cancel();
  PlanRequest request = s_.motion.request_plan(arm(), std::move(move));
  request.search = search;
  request.replans = replans;
  if (mode() != api::PlanningMode::kDirect && !may_touch(request.request.move)) {
    request.surroundings = setup_.surroundings->gather(setup_.index, s_.planning);
  }
  request.steps = latency_steps(request.request.move, search);
  const bool at_once = request.steps == 0;
  s_.plans.begin(std::make_shared<PlanJob>(arm().planner, std::move(request)), setup_.prefetcher);
  if (at_once) begin_planned();
}

Result<std::shared_ptr<MovePreview>> RobotController::preview(
    PlannedMove move, std::optional<api::PlanningMode> mode) const {
  const auto refused = [](const std::string& why) {
    return aprsim::fail(ErrorCode::kFailedPrecondition, "robot", why);
  };
  if (s_.stream.active()) return refused("busy: " + s_.stream.commander() + kHasTheRobot);
  if (s_.changer.busy()) return refused(kBusyChanger);
  if (!initialized()) {
    return refused(s_.command.in_error() ? status().description : kNotInitialized);
  }
  const bool knows = setup_.surroundings != nullptr && !may_touch(move);
  MovePreview::Setup setup{.arm = arm(),
                           .motion = s_.motion,
                           .request = {std::move(move), X_FT(), s_.tool_limits},
                           .latency = setup_.latency};
  if (setup_.surroundings) setup.mode = mode.value_or(s_.planning);
  const bool direct = setup.mode == api::PlanningMode::kDirect;
  if (knows) {
    setup.surroundings =
        setup_.surroundings->gather(setup_.index, direct ? api::PlanningMode::kCheck : setup.mode);
  }
  return std::make_shared<MovePreview>(std::move(setup));
}

/// Whether another robot has begun a motion that the plan does not know.
bool RobotController::is_outdated(const PlanRequest& request) const {
  return request.surroundings && setup_.surroundings &&
         request.surroundings->motions_of_others !=
             setup_.surroundings->motions_of_others(setup_.index);
}

/// The planned motion begins, or its command is refused. A move that waits is planned next.
void RobotController::begin_planned() {
  // Deterministic deadline: if the planning thread is late, this thread waits for it, and simulated
  // time with it.
  const std::shared_ptr<PlanJob> job = s_.plans.take();
  if (setup_.prefetcher != nullptr && !job->ready()) ++plan_waits_;
  const Plan& plan = job->get();
  std::optional<MoveRequest> waiting = s_.plans.take_waiting();
  // A plan that does not match the state is made again, or dropped for the waiting move.
  const bool expected = s_.motion.is_as_expected(arm(), plan);
  const PlanRequest& request = job->request();
  const bool outdated = is_outdated(request);
  if (outdated && !waiting && request.replans == kMostReplans) return fail(kOthersMove);
  if (!expected || plan.search_wanted || outdated) {
    const bool search = expected && (plan.search_wanted || (outdated && request.search));
    const int replans = waiting ? 0 : request.replans + (outdated ? 1 : 0);
    return begin_planning(waiting ? *std::move(waiting) : request.request, search, replans);
  }
  if (plan.outcome) {
    const PlannedMove& move = request.request.move;
    s_.motion.begin(arm(), move, plan);
    ++s_.motions_begun;
    s_.path = plan.path;
    s_.arrival_tolerance = arrival_tolerance_of(move);
    update_goal();
  } else if (!waiting) {
    // The error then belongs to the command in the status, with a prefix that names the
    // move.
    // The latest command may be a concurrent action.
    const std::string& reason = plan.outcome.error().message;
    fail(s_.command.task() == Task::kRest ? reason : std::string(kMoveBefore) + reason);
  }
  if (waiting) begin_planning(*std::move(waiting));
}

// ---- tool changer

/// The command is executed after the tool change; the status is already its own.
void RobotController::defer(api::Ticket ticket, const api::RobotAction& action) {
  s_.command.accept(ticket, api::kind_of(action));
  if (!s_.changer.defer(ticket, action)) return fail(kTooManyDeferred);
  s_.command.wait();
}

void RobotController::finish_tool_change() {
  if (s_.command.task() == Task::kToolChanger) {
    s_.command.complete(s_.changer.closed_on_nothing() ? kNothingTaken : nullptr);
  }
  run_deferred();
}

/// Executes the deferred commands in order, up to the next tool change. The status is that of the
/// latest command.
void RobotController::run_deferred() {
  if (s_.changer.deferred().empty()) return;
  const api::Ticket latest = s_.changer.deferred().back().ticket;
  const api::ActionKind kind = api::kind_of(s_.changer.deferred().back().action);
  while (!s_.changer.deferred().empty() && !s_.changer.busy()) {
    const DeferredCommand next = s_.changer.take_deferred();
    run(next.ticket, next.action, reference());
  }
  if (!s_.changer.deferred().empty()) s_.command.accept(latest, kind);
}

// ---- completion of the running command

void RobotController::check_completion(const ControllerInput& input) {
  switch (s_.command.task()) {
    case Task::kNone:
    case Task::kToolChanger:  // see finish_tool_change()
      break;
    case Task::kRest:
      if (at_rest() && !s_.motion.drives().releasing() && has_arrived(input.q_actual)) {
        complete_motion();
      }
      break;
    case Task::kGripper:
      // The input of the first step still belongs to the setting before.
      --s_.steps_left;
      if (s_.gripper_applied && (input.gripper_settled || s_.steps_left <= 0)) {
        s_.command.complete();
      }
      s_.gripper_applied = true;
      break;
    // A dwell of n steps ends after its n-th step.
    case Task::kDwell:
      if (--s_.steps_left <= 0) s_.command.complete();
      break;
  }
}

/// Whether an arm that was at `q_actual` before this step (empty: at the reference) is within the
/// command's tolerance.
bool RobotController::has_arrived(const JointVector& q_actual) const {
  if (q_actual.size() == 0) return true;
  return robot::has_arrived(s_.arrival_tolerance, setup_.model, setup_.X_BR.inverse(), X_FT(),
                            q_actual, s_.motion.last_reference());
}

/// The description reports a joint in torque mode that is in balance with its load.
void RobotController::complete_motion() {
  const int joint = s_.motion.balanced_joint();
  if (joint < 0) return s_.command.complete();
  char text[160];
  std::snprintf(text, sizeof text, "%s is held at %.2f deg by what it presses against",
                setup_.model.joints[static_cast<std::size_t>(joint)].name.c_str(),
                reference()(joint) * 180 / std::numbers::pi);
  s_.command.complete(text);
}

// ---- stops and errors

void RobotController::protective_stop(const std::string& reason, const JointVector& q_actual) {
  // The reference rests at the arm's actual posture.
  s_.plans.cancel();
  s_.motion.set_at_rest(q_actual);
  s_.protection = true;
  s_.stream.stopped(reason, s_.motion);
  s_.stream.set_alarm(reason);
  fail(reason);
  // The retreat releases the squeezed contact; it follows the trail that the arm came by.
  s_.motion.retreat(arm(), q_actual);
  ++s_.motions_begun;
}

void RobotController::protective_stop(const std::string& reason) {
  brake(Brake::kHard);
  s_.protection = true;
  s_.stream.stopped(reason, s_.motion);
  s_.stream.set_alarm(reason);
  fail(reason);
}

void RobotController::stop_by_guard(bool ends_command, const std::string& why) {
  brake(Brake::kHard);
  s_.stream.stopped(why, s_.motion);
  if (!ends_command) return;
  // The command ends well, with the trigger as its description.
  begin_task(Task::kRest);
  s_.command.set_description(why);
}

void RobotController::fail(const std::string& reason) {
  s_.changer.cancel();
  s_.command.set_error(reason);
  // A stream is not concerned by an error of a command.
  if (!s_.stream.active()) brake(Brake::kSet);
}

void RobotController::shut_down(const std::string& reason, bool on_path) {
  // The hardest braking comes first: fail() then finds nothing left to brake.
  if (on_path) {
    brake(Brake::kHard);
  } else {
    stop_from(reference());
  }
  s_.stream.stopped(reason, s_.motion);
  s_.stream.set_alarm(reason);
  fail(reason);
  s_.motion.switch_drives_off_after(0);
}

void RobotController::refuse(api::Ticket ticket, const api::RobotAction& action,
                             const std::string& reason) {
  s_.command.accept(ticket, api::kind_of(action));
  s_.command.set_error(reason);
}

void RobotController::slow_down(double share) { s_.motion.set_speed_share(share, s_.protection); }

// ---- state

void RobotController::begin_task(Task task) {
  s_.command.begin(task);
  s_.arrival_tolerance = {};
}

/// Whether the robot is initialized; else sets the error.
bool RobotController::require_initialized() {
  if (!s_.command.in_error() && !initialized()) fail(kNotInitialized);
  return initialized();
}

/// Cancels planning and brakes on the path.
void RobotController::brake(Brake how) {
  s_.plans.cancel();
  s_.motion.brake(arm(), how);
}

void RobotController::stop_from(const JointVector& q) {
  s_.plans.cancel();
  s_.motion.stop_from(arm(), q);
}

/// The running and the next motion lead the tool to the goal.
void RobotController::update_goal() {
  s_.X_RG.reset();
  if (s_.motion.idle()) return;
  s_.X_RG = Pose::from(setup_.X_BR.inverse() * flange_pose(setup_.model, s_.motion.end()) * X_FT());
}

std::optional<Pose> RobotController::X_RG() const {
  return moving() && !s_.command.in_error() ? s_.X_RG : std::nullopt;
}

ControllerState RobotController::save() const {
  ControllerState state = s_;
  // A plan in progress would allocate later, and is made again from its request.
  // A shared plan must not be modified through a saved state.
  state.plans = state.plans.unmade();
  return state;
}

void RobotController::restore(const ControllerState& state) {
  s_ = state;
  s_.plans.replan(arm().planner, setup_.prefetcher);
}

}  // namespace aprsim::robot
