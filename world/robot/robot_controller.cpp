#include "world/robot/robot_controller.hpp"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>
#include <stdexcept>
#include <utility>

#include "world/robot/limit_settings.hpp"
#include "world/robot/motion_planner.hpp"

namespace aprsim::robot {
namespace {

constexpr double kGripperDeadline_s = 2;
const char* const kNotInitialized = "not initialized: the robot must be initialized first";

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

/// What the running command still waits for.
enum class Task { kNone, kRest, kGripper, kDwell };

}  // namespace

struct RobotController::State {
  explicit State(ControllerSetup given)
      : setup(checked(std::move(given))),
        planner(setup),
        limits(tool_maximum(setup)),
        running(std::make_unique<Motion>(setup.model, *setup.ik, setup.X_FT)),
        next(std::make_unique<Motion>(setup.model, *setup.ik, setup.X_FT)),
        reference(setup.q_home),
        before(reference),
        before_that(reference),
        joint_targets(reference) {
    status.description.reserve(512);
  }

  // ---- commands ----
  void execute(const api::InitRobot&, const JointVector& q_actual);
  void execute(const api::EndRobot&, const JointVector& q_actual);
  void execute(const api::StopMotion& stop, const JointVector& q_actual);
  void execute(const api::MoveTo& move, const JointVector& q_actual);
  void execute(const api::MoveJoints& move, const JointVector& q_actual);
  template <typename Action>
  void execute(const Action&, const JointVector&) {
    if (ready()) set_error("not implemented");
  }
  void execute(const api::SetGripper& gripper, const JointVector& q_actual);
  void execute(const api::Dwell& dwell, const JointVector& q_actual);
  void execute(const api::SetMotionLimit& setting, const JointVector& q_actual);

  /// Whether the robot takes commands that act; else the state is error.
  bool ready();
  void set_error(const std::string& reason);
  void working(Task what);
  void done();

  // ---- motion ----
  /// Brakes what runs, forgets what was to follow; returns where the robot will be at rest.
  JointVector brake(Brake how);
  void stop_at_once(const JointVector& from);
  void start(const Result<void>& planned);
  void advance();

  ControllerSetup setup;
  MotionPlanner planner;
  LimitSettings limits;
  std::unique_ptr<Motion> running, next;
  bool is_running = false, has_next = false;
  std::optional<Brake> braking;
  JointVector reference, before, before_that;
  JointVector joint_targets;
  bool joint_move = false;  ///< the running motion goes to joint_targets

  api::ActionStatus status;
  Task task = Task::kNone;
  std::string held_error;
  bool initialized = false, protection = false;
  double gripper_setting = 1;
  std::int64_t steps_left = 0;   ///< of a dwell, or until a gripper's deadline
  bool gripper_applied = false;  ///< a step has passed since the command
};

bool RobotController::State::ready() {
  if (!held_error.empty()) return false;  // take() has set the state already
  if (!initialized) set_error(kNotInitialized);
  return initialized;
}

void RobotController::State::set_error(const std::string& reason) {
  held_error = reason;
  initialized = false;
  task = Task::kNone;
  status.state = api::ActionState::kError;
  status.description = reason;
  if (is_running) brake(Brake::kSet);
}

void RobotController::State::working(Task what) {
  task = what;
  if (held_error.empty()) status.state = api::ActionState::kWorking;
}

void RobotController::State::done() {
  task = Task::kNone;
  if (held_error.empty()) status.state = api::ActionState::kDone;
}

JointVector RobotController::State::brake(Brake how) {
  has_next = false;
  joint_move = false;
  if (!is_running) return reference;
  const bool already = braking && (*braking == how || *braking == Brake::kHard);
  if (!already) {
    running->brake(how);
    braking = how;
  }
  return running->end();
}

/// From `from`, which is the reference or where the arm really is, at the reference's speed.
void RobotController::State::stop_at_once(const JointVector& from) {
  has_next = false;
  joint_move = false;
  const JointVector shift = from - reference;
  reference = from;
  before += shift;
  before_that += shift;
  if (!is_running) return;
  const double dt = setup.step_s;
  const JointVector qdd = (reference - 2 * before + before_that) / (dt * dt);
  const JointVector qd = (reference - before) / dt + qdd * (dt / 2);
  planner.plan_stop(from, qd, qdd, *running);
  braking = Brake::kHard;
}

/// Lets the motion planned in `next` follow what runs, or refuses the command.
void RobotController::State::start(const Result<void>& planned) {
  if (!planned) {
    set_error(planned.error().message);
    return;
  }
  has_next = true;
  working(Task::kRest);
}

void RobotController::State::advance() {
  before_that = before;
  before = reference;
  if (!is_running && has_next) {
    std::swap(running, next);
    has_next = false;
    is_running = true;
    braking.reset();
  }
  if (!is_running) return;
  if (running->advance(setup.step_s, reference)) is_running = false;
}

void RobotController::State::execute(const api::InitRobot&, const JointVector& q_actual) {
  held_error.clear();
  status.description.clear();
  protection = false;
  initialized = true;
  stop_at_once(q_actual);
  working(Task::kRest);
}

void RobotController::State::execute(const api::EndRobot&, const JointVector&) {
  initialized = false;
  brake(Brake::kSet);
  working(Task::kRest);
}

void RobotController::State::execute(const api::StopMotion& stop, const JointVector&) {
  switch (stop.kind) {
    case api::StopKind::kImmediate:
      stop_at_once(reference);
      break;
    case api::StopKind::kFast:
      brake(Brake::kHard);
      break;
    case api::StopKind::kNormal:
      brake(Brake::kSet);
      break;
  }
  working(Task::kRest);
}

void RobotController::State::execute(const api::MoveTo& move, const JointVector&) {
  if (!ready()) return;
  const JointVector from = brake(Brake::kSet);
  start(planner.plan(move, from, limits.effective(), limits.maximum(), *next));
}

void RobotController::State::execute(const api::MoveJoints& move, const JointVector&) {
  if (!ready()) return;
  const bool keep_targets = (is_running || has_next) && joint_move;
  const JointVector from = brake(Brake::kSet);
  if (!keep_targets) joint_targets = from;
  start(planner.plan(move, from, limits.maximum(), joint_targets, *next));
  joint_move = has_next;
}

void RobotController::State::execute(const api::SetGripper& gripper, const JointVector&) {
  if (!ready()) return;
  if (!(gripper.setting >= 0 && gripper.setting <= 1)) {
    char text[96];
    std::snprintf(text, sizeof text, "gripper setting %g is outside its limits 0 to 1",
                  gripper.setting);
    set_error(text);
    return;
  }
  brake(Brake::kSet);
  gripper_setting = gripper.setting;
  gripper_applied = false;
  steps_left = std::llround(kGripperDeadline_s / setup.step_s);
  working(Task::kGripper);
}

void RobotController::State::execute(const api::Dwell& dwell, const JointVector&) {
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
  steps_left = whole + (dwell.duration.count() % step_ns != 0 ? 1 : 0);
  working(Task::kDwell);
}

void RobotController::State::execute(const api::SetMotionLimit& setting, const JointVector&) {
  if (const auto ok = limits.set(setting); !ok) {
    if (held_error.empty()) set_error(ok.error().message);
    return;
  }
  done();
}

RobotController::RobotController(ControllerSetup setup)
    : state_(std::make_unique<State>(std::move(setup))) {}
RobotController::~RobotController() = default;
RobotController::RobotController(RobotController&&) noexcept = default;
RobotController& RobotController::operator=(RobotController&&) noexcept = default;

void RobotController::take(api::Ticket ticket, const api::RobotAction& action,
                           const JointVector& q_actual) {
  state_->status.ticket = ticket;
  std::visit([&](const auto& command) { state_->execute(command, q_actual); }, action);
}

const JointVector& RobotController::step(bool gripper_settled) {
  State& s = *state_;
  s.advance();
  const bool resting = !s.is_running && !s.has_next;
  switch (s.task) {
    case Task::kNone:
      break;
    case Task::kRest:
      if (resting) s.done();
      break;
    case Task::kGripper:
      // What is seen before the first step was settled under the setting before.
      --s.steps_left;
      if (resting && s.gripper_applied && (gripper_settled || s.steps_left <= 0)) s.done();
      s.gripper_applied = true;
      break;
    case Task::kDwell:
      // The time runs from rest.
      if (resting && --s.steps_left <= 0) s.done();
      break;
  }
  return s.reference;
}

void RobotController::protective_stop(const std::string& reason, const JointVector& q_actual) {
  State& s = *state_;
  s.is_running = s.has_next = s.joint_move = false;
  s.reference = s.before = s.before_that = q_actual;
  s.protection = true;
  s.set_error(reason);
}

void RobotController::protective_stop(const std::string& reason) {
  State& s = *state_;
  s.brake(Brake::kHard);
  s.protection = true;
  s.set_error(reason);
}

const api::ActionStatus& RobotController::status() const { return state_->status; }
const JointVector& RobotController::reference() const { return state_->reference; }
double RobotController::gripper_setting() const { return state_->gripper_setting; }
bool RobotController::initialized() const { return state_->initialized; }
bool RobotController::stopped_by_protection() const { return state_->protection; }
bool RobotController::moving() const { return state_->is_running || state_->has_next; }
api::LimitSetting RobotController::limit(api::MotionLimit which) const {
  return state_->limits.get(which);
}

}  // namespace aprsim::robot
