#include "world/robot/controller/robot_controller.hpp"

#include <cmath>
#include <stdexcept>
#include <utility>

#include "world/robot/controller/controller_core.hpp"
#include "world/robot/kinematics/kinematics.hpp"

namespace aprsim::robot {
namespace {

const char* const kNotInitialized = "not initialized: the robot must be initialized first";
/// How far the tool backs off after a collision, or the joints where the tool hardly moves.
constexpr double kRetreat_m = 1e-2, kRetreat_rad = 0.03;
constexpr std::size_t kReasonCapacity = 512;

/// Fills in what must hold before anything is built on the setup.
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

ToolLimits tool_maximum(const ControllerSetup& setup) {
  return {setup.max_trans_speed_m_s, setup.max_trans_accel_m_s2, setup.max_rot_speed_rad_s,
          setup.max_rot_accel_rad_s2};
}

}  // namespace

RobotController::Core::Core(ControllerSetup given)
    : setup(checked(std::move(given))), planner(setup), s(tool_maximum(setup), setup.q_home) {
  s.status.description.reserve(kReasonCapacity);
  s.note.reserve(kReasonCapacity);
}

bool RobotController::Core::ready() {
  if (!s.held_error.empty()) return false;  // take() has set the state already
  if (!s.initialized) set_error(kNotInitialized);
  return s.initialized;
}

void RobotController::Core::set_error(const std::string& reason) {
  s.held_error = reason;
  s.initialized = false;
  s.task = Task::kNone;
  s.status.state = api::ActionState::kError;
  s.status.description = reason;
  brake(Brake::kSet);
}

void RobotController::Core::working(Task what) {
  s.task = what;
  s.arrival = {};
  s.note.clear();
  if (!s.held_error.empty()) return;
  s.status.state = api::ActionState::kWorking;
  s.status.description.clear();
}

void RobotController::Core::done() {
  s.task = Task::kNone;
  if (!s.held_error.empty()) return;
  s.status.state = api::ActionState::kDone;
  s.status.description = s.note;
}

Eigen::Isometry3d RobotController::Core::X_FT() const {
  return s.tool_mounted ? setup.X_FT : Eigen::Isometry3d::Identity();
}

void RobotController::Core::note_goal() {
  switch (s.status.kind) {
    case api::ActionKind::kGripperForce:
    case api::ActionKind::kOverride:
    case api::ActionKind::kMotionLimit:
      return;  // these leave a motion alone
    case api::ActionKind::kMoveTo:
    case api::ActionKind::kMoveThroughTo:
    case api::ActionKind::kMoveScrew:
    case api::ActionKind::kMoveJoints:
      if (s.has_next || s.is_running) {
        const JointVector& end = s.has_next ? s.next.end() : s.running.end();
        s.X_RG = Pose::from(setup.X_BR.inverse() * flange_pose(setup.model, end) * X_FT());
        return;
      }
      break;
    default:
      break;
  }
  s.X_RG.reset();
}

PlanStart RobotController::Core::plan_start(const JointVector& q) const { return {q, X_FT()}; }

JointVector RobotController::Core::brake(Brake how) {
  s.has_next = false;
  s.joint_move = false;
  s.backing_off = false;
  if (s.torque.active()) stop_at_once(s.reference);
  if (!s.is_running) return s.reference;
  const bool already = s.braking && (*s.braking == how || *s.braking == Brake::kHard);
  if (!already) {
    s.running.brake(arm(), how);
    s.braking = how;
  }
  return s.running.end();
}

PassingState RobotController::Core::passing() const {
  const double dt = setup.step_s;
  const JointVector qdd = (s.reference - 2 * s.before + s.before_that) / (dt * dt);
  return {s.reference, (s.reference - s.before) / dt + qdd * (dt / 2), qdd};
}

/// From `from`, which is the reference or where the arm really is, at the reference's speed.
void RobotController::Core::stop_at_once(const JointVector& from) {
  const bool pressed = s.torque.active();
  s.has_next = false;
  s.joint_move = false;
  s.backing_off = false;
  s.torque.clear();
  const JointVector shift = from - s.reference;
  s.reference = from;
  s.before += shift;
  s.before_that += shift;
  if (!s.is_running && !pressed) return;
  planner.plan_stop(passing(), s.running);
  s.is_running = true;
  s.braking = Brake::kHard;
}

bool RobotController::Core::near_enough(const JointVector& q_actual) const {
  if (q_actual.size() == 0) return true;
  return has_arrived(s.arrival, setup.model, setup.X_BR.inverse(), X_FT(), q_actual, s.before);
}

void RobotController::Core::start(const Result<void>& planned) {
  if (!planned) {
    set_error(planned.error().message);
    return;
  }
  switch_drives_on();
  s.next.set_speed(s.override_fraction);
  s.has_next = true;
  working(Task::kRest);
}

void RobotController::Core::start_in_passing(const ToolLimits& tool) {
  if (!s.is_running || !s.has_next) return;
  if (!planner.blend_from_motion(passing(), plan_start(s.reference), tool, s.next)) return;
  s.next.set_speed(s.override_fraction);
  std::swap(s.running, s.next);
  s.has_next = false;
  s.braking.reset();
}

void RobotController::Core::advance() {
  s.before_that = s.before;
  s.before = s.reference;
  if (s.drives.braked()) return;
  if (!s.is_running && s.has_next) {
    std::swap(s.running, s.next);
    s.has_next = false;
    s.is_running = true;
    s.braking.reset();
  }
  if (!s.is_running) return;
  if (s.running.advance(arm(), setup.step_s, s.reference)) s.is_running = false;
}

/// The joints that are driven by torque, on top of what the others do.
void RobotController::Core::press(const JointVector& external_nm) {
  if (!s.torque.active() || s.drives.braked()) return;
  if (s.torque_waits && (s.is_running || s.has_next)) return;
  s.torque_waits = false;
  const JointVector inertia = mass_matrix(setup.model, setup.payload, s.before).diagonal();
  s.torque.advance({.limits = planner.joint_limits(),
                    .external_nm = external_nm,
                    .inertia = inertia,
                    .speed = s.override_fraction,
                    .step_s = setup.step_s},
                   s.reference);
}

/// Back on the way the arm has come, until the tool is a few millimetres from where it was stopped.
void RobotController::Core::retreat(const JointVector& from) {
  const auto tool = [&](const JointVector& q) {
    return Eigen::Vector3d((flange_pose(setup.model, q) * X_FT()).translation());
  };
  const Eigen::Vector3d here = tool(from);
  for (int age = 0; age < s.trail.count(); ++age) {
    const JointVector& q = s.trail.back(age);
    const bool last = age + 1 == s.trail.count();
    if (!last && (tool(q) - here).norm() < kRetreat_m &&
        (q - from).cwiseAbs().maxCoeff() < kRetreat_rad) {
      continue;
    }
    switch_drives_on();
    planner.plan_retreat(from, q, s.running);
    s.is_running = s.backing_off = true;
    s.braking.reset();
    break;
  }
  s.trail.clear();
}

RobotController::RobotController(ControllerSetup setup)
    : core_(std::make_unique<Core>(std::move(setup))) {}
RobotController::~RobotController() = default;
RobotController::RobotController(RobotController&&) noexcept = default;
RobotController& RobotController::operator=(RobotController&&) noexcept = default;

void RobotController::take(api::Ticket ticket, const api::RobotAction& action,
                           const JointVector& q_actual) {
  core_->s.status.ticket = ticket;
  core_->s.status.kind = api::kind_of(action);
  std::visit([&](const auto& command) { core_->execute(command, q_actual); }, action);
  core_->note_goal();
}

const JointVector& RobotController::step(const ControllerInput& input) {
  Core& core = *core_;
  ControllerState& s = core.s;
  s.drives.step(core.resting());
  core.advance();
  core.press(input.external_nm);
  s.trail.record(s.reference);
  switch (s.task) {
    case Task::kNone:
      break;
    case Task::kRest:
      if (core.resting() && !s.drives.releasing() && core.near_enough(input.q_actual)) {
        core.arrived();
      }
      break;
    case Task::kGripper:
      // What is seen before the first step was settled under the setting before.
      --s.steps_left;
      if (core.resting() && s.gripper_applied && (input.gripper_settled || s.steps_left <= 0)) {
        core.done();
      }
      s.gripper_applied = true;
      break;
    case Task::kToolChanger:
      if (core.resting()) core.change_tool(input.tool_at_flange);
      break;
    case Task::kDwell:
      // The time runs from rest.
      if (core.resting() && --s.steps_left <= 0) core.done();
      break;
  }
  return s.reference;
}

void RobotController::protective_stop(const std::string& reason, const JointVector& q_actual) {
  ControllerState& s = core_->s;
  s.is_running = s.has_next = s.joint_move = false;
  s.torque.clear();
  s.reference = s.before = s.before_that = q_actual;
  s.protection = true;
  core_->set_error(reason);
  core_->retreat(q_actual);
}

void RobotController::protective_stop(const std::string& reason) {
  core_->brake(Brake::kHard);
  core_->s.protection = true;
  core_->set_error(reason);
}

void RobotController::stop_by_guard(bool ends_command, const std::string& why) {
  core_->brake(Brake::kHard);
  if (!ends_command) return;
  core_->working(Task::kRest);
  core_->s.note.assign(why, 0, kReasonCapacity);
}

void RobotController::fail(const std::string& reason) { core_->set_error(reason); }

const ControllerState& RobotController::state() const { return core_->s; }
void RobotController::restore(const ControllerState& state) { core_->s = state; }

const api::ActionStatus& RobotController::status() const { return core_->s.status; }
std::optional<Pose> RobotController::X_RG() const {
  const bool goes = !core_->resting() && core_->s.held_error.empty();
  return goes ? core_->s.X_RG : std::nullopt;
}
const JointVector& RobotController::reference() const { return core_->s.reference; }
double RobotController::gripper_setting() const { return core_->s.gripper_setting; }
bool RobotController::initialized() const { return core_->s.initialized; }
bool RobotController::stopped_by_protection() const { return core_->s.protection; }
bool RobotController::moving() const { return !core_->resting(); }
bool RobotController::backing_off() const { return core_->s.backing_off && core_->s.is_running; }
bool RobotController::drives_on() const { return core_->s.drives.on(); }
bool RobotController::braked() const { return core_->s.drives.braked(); }
bool RobotController::tool_mounted() const { return core_->s.tool_mounted; }
Eigen::Isometry3d RobotController::X_FT() const { return core_->X_FT(); }
double RobotController::override_fraction() const { return core_->s.override_fraction; }
JointVector RobotController::pressing() const {
  return core_->s.torque.pressing(core_->setup.model.dof());
}
api::LimitSetting RobotController::limit(api::MotionLimit which) const {
  return core_->s.limits.get(which);
}

}  // namespace aprsim::robot
