#include "world/robot/controller/motion_generator.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "world/robot/kinematics/dynamics.hpp"

namespace aprsim::robot {
namespace {

/// Retreat after a collision: by this distance of the tool or this rotation of a joint.
constexpr double kRetreat_m = 1e-2, kRetreat_rad = 0.03;
/// Release time of holding brakes of servo motors of this size, an estimate.
constexpr double kBrakeRelease_s = 0.1;

}  // namespace

void MotionGenerator::step(const EquippedArm& arm, const JointVector& external_nm, bool planning) {
  // Order: drives first, since brakes hold the reference in the same step.
  drives_.step(at_rest() && !planning);
  runner_.advance(arm.planner.arm(), arm.step_s, drives_.braked());
  advance_torque_mode(arm, external_nm);
  advance_stream(arm);
  trail_.record(reference());
}

// ---- motions

PlanRequest MotionGenerator::request_plan(const EquippedArm& arm, MoveRequest move) {
  // Joints that the command does not name keep the targets of the move that it replaces.
  const bool keep_targets = to_joint_targets_ && !runner_.idle();
  torque_mode_pending_ = torque_mode_.active();
  if (torque_mode_.active()) stop_from(arm, reference());
  PlanRequest request{
      .request = std::move(move), .step_s = arm.step_s, .runner = runner_, .drive_power = drives_};
  if (keep_targets) request.joint_targets = joint_targets_;
  return request;
}

bool MotionGenerator::is_as_expected(const EquippedArm& arm, const Plan& plan) const {
  // A plan is made ahead from a copy of the runner. It is only valid if the prediction was exact,
  // which a bitwise comparison tests.
  MotionRunner braked = runner_;
  const JointVector rest = braked.brake(arm.planner.arm(), Brake::kSet);
  const JointState state = runner_.state(arm.step_s);
  return plan.rest == rest && plan.state.q == state.q && plan.state.qd == state.qd &&
         plan.state.qdd == state.qdd;
}

void MotionGenerator::begin(const EquippedArm& arm, const PlannedMove& move, const Plan& plan) {
  const auto* joints = std::get_if<api::MoveJoints>(&move);
  if (joints) torque_mode_pending_ = torque_mode_pending_ || runner_.running();
  retreating_ = false;
  switch_drives_on(arm.step_s);
  MotionSequence next = plan.blended ? MotionSequence(*plan.blended) : MotionSequence(plan.motions);
  // The override may have changed while the plan was made.
  next.set_speed(speed());
  // Blending replaces the running motion at its state. Otherwise the next one waits until that has
  // come to rest.
  if (plan.blended) {
    runner_.replace(std::move(next));
  } else {
    runner_.brake(arm.planner.arm(), Brake::kSet);
    runner_.queue(std::move(next));
  }
  to_joint_targets_ = joints != nullptr;
  if (!joints) return;
  joint_targets_ = plan.joint_targets;
  start_torque_mode(arm, *joints, plan);
}

void MotionGenerator::retreat(const EquippedArm& arm, const JointVector& from) {
  const auto tool = [&](const JointVector& q) {
    return Eigen::Vector3d((flange_pose(arm.model(), q) * arm.X_FT).translation());
  };
  const Eigen::Vector3d here = tool(from);
  // From the newest posture back: the first one that is far enough is the shortest retreat along
  // known free space.
  for (int age = 0; age < trail_.count(); ++age) {
    const JointVector& q = trail_.back(age);
    // The oldest posture is far enough in any case.
    const bool last = age + 1 == trail_.count();
    if (!last && (tool(q) - here).norm() < kRetreat_m &&
        (q - from).cwiseAbs().maxCoeff() < kRetreat_rad) {
      continue;
    }
    switch_drives_on(arm.step_s);
    runner_.replace(MotionSequence(arm.planner.plan_retreat(from, q)));
    retreating_ = true;
    break;
  }
  trail_.clear();
}

// ---- torque mode

/// Joints in torque mode start at rest, at the same time as the motion of the others.
void MotionGenerator::start_torque_mode(const EquippedArm& arm, const api::MoveJoints& move,
                                        const Plan& plan) {
  const JointLimits& limits = arm.planner.joint_limits();
  for (const api::JointTarget& target : move.targets) {
    if (!target.torque) continue;
    const auto i = static_cast<Eigen::Index>(target.joint);
    torque_mode_.add(
        {target.joint, std::clamp(position_of(target, plan.held), limits.lower(i), limits.upper(i)),
         target.torque->setting_nm, target.torque->rate_nm_s.value_or(0)},
        plan.rest(i));
  }
}

/// Moves the joints in torque mode; the others follow their motion.
void MotionGenerator::advance_torque_mode(const EquippedArm& arm, const JointVector& external_nm) {
  if (!torque_mode_.active() || drives_.braked()) return;
  if (torque_mode_pending_ && !runner_.idle()) return;
  torque_mode_pending_ = false;
  const JointVector inertia =
      // The diagonal is the inertia that a joint sees while the others hold still.
      mass_matrix(arm.model(), arm.planner.payload(), runner_.last_reference()).diagonal();
  torque_mode_.advance({.limits = arm.planner.joint_limits(),
                        .external_nm = external_nm,
                        .inertia = inertia,
                        .speed = speed(),
                        .step_s = arm.step_s},
                       runner_.reference());
}

// ---- a streamed motion

void MotionGenerator::begin_stream(const EquippedArm& arm, api::StreamMode mode) {
  if (torque_mode_.active()) stop_from(arm, reference());
  to_joint_targets_ = false;
  retreating_ = false;
  stream_paused_ = false;
  switch_drives_on(arm.step_s);
  if (mode == api::StreamMode::kTimed) {
    stream_.emplace<TimedMotion>().begin(reference());
  } else {
    stream_.emplace<MoveChain>();
  }
}

std::uint64_t MotionGenerator::stream_left() const {
  if (const auto* points = std::get_if<TimedMotion>(&stream_)) return points->left();
  const auto* moves = std::get_if<MoveChain>(&stream_);
  return moves ? moves->left() : 0;
}

std::uint64_t MotionGenerator::stream_done() const {
  if (const auto* points = std::get_if<TimedMotion>(&stream_)) return points->done();
  const auto* moves = std::get_if<MoveChain>(&stream_);
  return moves ? moves->done() : 0;
}

void MotionGenerator::drop_points() {
  if (TimedMotion* points = timed()) points->clear();
  if (MoveChain* moves = chain()) moves->clear();
  stream_paused_ = false;
}

/// A stop comes first, and brakes hold the reference.
void MotionGenerator::advance_stream(const EquippedArm& arm) {
  if (stream_left() == 0 || drives_.braked() || !runner_.idle()) return;
  const JointLimits& limits = arm.planner.joint_limits();
  const double wanted = stream_paused_ ? 0 : speed();
  if (MoveChain* moves = chain()) {
    moves->advance({.limits = limits, .speed = wanted, .step_s = arm.step_s}, runner_.reference());
    return;
  }
  TimedMotion& points = *timed();
  const bool more = points.advance({.limits = limits, .speed = wanted, .step_s = arm.step_s},
                                   runner_.reference());
  if (more || !points.ends_moving()) return;
  // Points have run out at a speed: the joints stop as fast as they can.
  const JointState state = runner_.state(arm.step_s);
  runner_.replace(MotionSequence(arm.planner.plan_stop(state)), Brake::kHard);
}

std::size_t MotionGenerator::bytes() const {
  if (const auto* points = std::get_if<TimedMotion>(&stream_)) return points->bytes();
  const auto* moves = std::get_if<MoveChain>(&stream_);
  return moves ? moves->bytes() : 0;
}

// ---- stops

void MotionGenerator::brake(const EquippedArm& arm, Brake how) {
  to_joint_targets_ = false;
  retreating_ = false;
  // Torque mode has no path to brake on.
  // A stop from the present state in joint space takes the place of braking on a path.
  // The same for a streamed motion: points end where they are dropped.
  if (torque_mode_.active() || stream_left() > 0) stop_from(arm, reference());
  runner_.brake(arm.planner.arm(), how);
}

void MotionGenerator::stop_from(const EquippedArm& arm, const JointVector& q) {
  const bool moves = runner_.running() || torque_mode_.active() || stream_left() > 0;
  drop_points();
  to_joint_targets_ = false;
  retreating_ = false;
  torque_mode_.clear();
  runner_.drop_next();
  // The reference continues from the actual posture with its velocity, so that the servo sees no
  // jump.
  runner_.shift_to(q);
  if (!moves) return;
  const JointState state = runner_.state(arm.step_s);
  runner_.replace(MotionSequence(arm.planner.plan_stop(state)), Brake::kHard);
}

void MotionGenerator::set_at_rest(const JointVector& q) {
  to_joint_targets_ = false;
  torque_mode_.clear();
  drop_points();
  runner_.set_at_rest(q);
}

// ---- settings

void MotionGenerator::set_override(double fraction, bool next_only) {
  override_ = fraction;
  runner_.set_speed(speed(), next_only);
}

void MotionGenerator::set_speed_share(double share, bool next_only) {
  speed_share_ = share;
  runner_.set_speed(speed(), next_only);
}

void MotionGenerator::switch_drives_on(double step_s) {
  drives_.switch_on(static_cast<int>(std::lround(kBrakeRelease_s / step_s)));
}

}  // namespace aprsim::robot
