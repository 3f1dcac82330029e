#include "world/robot/planning/motion_planner.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "world/robot/kinematics/dynamics.hpp"
#include "world/robot/trajectory/limits/segment_limits.hpp"

namespace aprsim::robot {
namespace {

/// Shares of a joint's maximum, for joints that a command names without limits.
constexpr double kJointSpeedShare = 0.25, kJointAccelShare = 0.5;
constexpr double kLeastTravel = 1e-12;
constexpr double kAtLimit_rad = 1e-9;  ///< rounding of a limit that was meant exactly
constexpr int kRateSamples = 33;
/// A kept elbow angle must leave the joints within this share of their ranges, and cost at most
/// this much more joint motion than the best one.
constexpr double kClearShare = 0.98, kMaxDetour = 1.5;
/// Share of a joint's speed, for joints that hardly move but must slow down and return.
constexpr double kLeastBlendSpeed = 0.05;
constexpr double kRetreatScale = 0.3;
constexpr double kAtPose = 1e-6;  ///< of the joint ranges: the arm is at the pose already
// Parameters of torque_scaling().
constexpr int kTorqueSamples = 48;
constexpr double kTorqueDifference_s = 1e-3;
constexpr double kSlowestScale = 0.1;

std::string limit_text(const Joint& joint, double q) {
  const double unit = joint.prismatic ? 1000 : 180 / std::numbers::pi;
  const char* name = joint.prismatic ? "mm" : "deg";
  const bool below = q < joint.lower_rad;
  const double limit = (below ? joint.lower_rad : joint.upper_rad) * unit;
  const int digits = std::abs(q * unit - limit) < 0.1 ? 6 : 1;
  char text[160];
  std::snprintf(text, sizeof text, "%s at %.*f %s is %s than its limit %.*f %s", joint.name.c_str(),
                digits, q * unit, name, below ? "less" : "greater", digits, limit, name);
  return text;
}

/// The position within the joint's range, the torque within the drive's.
Result<void> check_target(const Joint& joint, const api::JointTarget& target, double position_rad) {
  if (position_rad < joint.lower_rad - kAtLimit_rad ||
      position_rad > joint.upper_rad + kAtLimit_rad) {
    return fail(ErrorCode::kUnreachable, joint.name, limit_text(joint, position_rad));
  }
  if (!target.torque || target.torque->setting_nm <= joint.max_torque_nm) return {};
  char text[160];
  std::snprintf(text, sizeof text, "%s: torque %g %s is greater than its limit %g %s",
                joint.name.c_str(), target.torque->setting_nm, joint.prismatic ? "N" : "Nm",
                joint.max_torque_nm, joint.prismatic ? "N" : "Nm");
  return fail(ErrorCode::kInvalidArgument, joint.name, text);
}

}  // namespace

double position_of(const api::JointTarget& target, const JointVector& held) {
  double position = target.position_rad;
  for (const api::JointShare& share : target.held) position += share.factor * held(share.joint);
  return position;
}

// Dynamic scaling: Hollerbach 1984. The torques of a motion slowed by the factor c are those that
// hold the arm plus c^2 times those that motion adds. Deviation: one factor for the whole motion.
double torque_scaling(const ArmModel& model, const Payload& payload,
                      const Eigen::Vector3d& gravity_B, double duration_s,
                      const std::function<JointVector(double)>& position) {
  const JointVector rest = JointVector::Zero(model.dof());
  double square = 1;  // of the scale
  for (int k = 0; k < kTorqueSamples; ++k) {
    const double t = duration_s * (k + 0.5) / kTorqueSamples;
    // Samples lie in the middle of equal intervals, so that t - h and t + h stay within the motion.
    const double h = std::min(kTorqueDifference_s, duration_s / (2 * kTorqueSamples));
    if (!(h > 0)) return 1;
    // Central differences.
    const JointVector before = position(t - h), q = position(t), after = position(t + h);
    const JointVector qd = (after - before) / (2 * h);
    const JointVector qdd = (after - 2 * q + before) / (h * h);
    // Torques that hold the arm, and that motion adds.
    const JointVector hold = inverse_dynamics(model, payload, gravity_B, q, rest, rest);
    const JointVector moving = inverse_dynamics(model, payload, gravity_B, q, qd, qdd) - hold;
    // The scale that leaves the worst drive its share.
    for (int i = 0; i < model.dof(); ++i) {
      const double limit = kTorqueShare * model.joints[static_cast<std::size_t>(i)].max_torque_nm;
      const double room = limit - std::copysign(1.0, moving(i)) * hold(i);
      // tau = hold + c^2 moving must stay within the limit: c^2 <= (limit - hold) / |moving|, with
      // the sign of the motion's torque.
      if (std::abs(moving(i)) * square > room) square = room / std::abs(moving(i));
    }
  }
  return std::sqrt(std::clamp(square, kSlowestScale * kSlowestScale, 1.0));
}

MotionPlanner::MotionPlanner(PlannerSetup setup)
    : setup_(std::make_shared<const PlannerSetup>(std::move(setup))),
      limits_(derive_joint_limits(setup_->model, setup_->payload, setup_->gravity_B)) {}

MotionPlanner MotionPlanner::until(const std::atomic<bool>& cancelled) const {
  MotionPlanner planner = *this;
  planner.cancelled_ = &cancelled;
  return planner;
}

MotionPlanner MotionPlanner::without_search(bool& wanted) const {
  MotionPlanner planner = *this;
  planner.search_wanted_ = &wanted;
  return planner;
}

// ---- whole motions from rest

Result<void> MotionPlanner::plan(const api::MoveTo& move, const PlanStart& start,
                                 const ToolLimitSettings& limits, MotionPlan& out) const {
  out.clear();
  const Eigen::Isometry3d X_BT = pose_in_base(move.X_RT);
  const ToolLimits tool = limits.effective(move.limits);
  if (move.straight) return add_line(X_BT, start, tool, limits.maximum(), out);
  // A free move is planned in joint space: only its end pose matters.
  const auto target = target_posture(X_BT * start.X_FT.inverse(), start.q);
  if (!target) return tl::unexpected(target.error());
  add_joint_motion(*target, start, tool, limits.maximum(), out);
  return {};
}

Result<void> MotionPlanner::plan(const api::MoveJoints& move, const PlanStart& start,
                                 const ToolLimitSettings& limits, JointVector& targets,
                                 MotionPlan& out) const {
  out.clear();
  // Default limits; joints with limits of their own run independently of the others.
  JointMove joints{.start = start.q, .target = targets, .limits = limits_, .maximum = limits_};
  joints.limits.speed *= kJointSpeedShare;
  joints.limits.accel *= kJointAccelShare;
  std::array<bool, kMaxDof> named{};
  for (const api::JointTarget& target : move.targets) {
    const int i = target.joint;
    const auto slot = static_cast<std::size_t>(i);
    const Joint& joint = setup_->model.joints[slot];
    const double position = position_of(target, targets);
    if (auto ok = check_target(joint, target, position); !ok) return ok;
    if (named[slot]) {
      return fail(ErrorCode::kInvalidArgument, joint.name, joint.name + " is named twice");
    }
    named[slot] = true;
    if (target.torque) {  // torque mode moves it
      joints.target(i) = start.q(i);
      continue;
    }
    joints.target(i) = std::clamp(position, limits_.lower(i), limits_.upper(i));
    joints.independent[slot] = target.speed_rad_s || target.accel_rad_s2;
    if (target.speed_rad_s) {
      joints.limits.speed(i) = std::min(*target.speed_rad_s, limits_.speed(i));
    }
    if (target.accel_rad_s2) {
      joints.limits.accel(i) = std::min(*target.accel_rad_s2, limits_.accel(i));
    }
  }
  // The jerk follows from the time in which an acceleration builds up.
  joints.limits.jerk = joints.limits.accel / kJerkTime_s;
  limit_tool_rates(joints, start.X_FT, limits.maximum(), limits.maximum());
  plan_joint_motion(joints, out.add().as_joint());
  targets = joints.target;
  return {};
}

// ---- motions from a moving arm

/// Every joint independently from its state to its target, at speeds in the proportion of the ways,
/// so that they arrive nearly together.
std::optional<JointMotion> MotionPlanner::blend_from_motion(const JointState& state,
                                                            const Eigen::Isometry3d& X_FT,
                                                            const ToolLimits& tool,
                                                            const ToolLimits& maximum,
                                                            const JointMotion& from_rest) const {
  // The same task from the present state.
  JointMove move = from_rest.move();
  move.start = state.q;
  move.qd = state.qd;
  move.qdd = state.qdd;
  move.time_scale = 1;
  limit_tool_rates(move, X_FT, tool, maximum);
  const int dof = setup_->model.dof();
  const Jacobian J = point_jacobian(setup_->model, state.q, dof, X_FT.translation());
  for (int i = 0; i < dof; ++i) {
    // The joint's part of the shared profile; enough to reverse a joint that moves in the opposite
    // direction. Independent profiles from a moving state (Kroeger & Wahl 2010). The shared profile
    // gives each joint its speed, so that the path stays close to a line in joint space.
    const double distance = std::abs(move.target(i) - move.start(i));
    const double lever = std::max(J.col(i).head<3>().norm(), kLeastTravel);
    const double least_speed = std::max(std::abs(move.qd(i)), kLeastBlendSpeed * limits_.speed(i));
    const double least_accel = 0.5 * tool.trans_accel_m_s2 / lever;
    move.limits.speed(i) =
        std::min(move.limits.speed(i), std::max(move.progress_speed * distance, least_speed));
    move.limits.accel(i) =
        std::min(move.limits.accel(i), std::max(move.progress_accel * distance, least_accel));
    move.limits.jerk(i) = limits_.jerk(i);
  }
  JointMotion motion;
  motion.plan(move);
  // A profile from a moving state cannot be slowed for the torques as a whole.
  if (motion.beyond_range() > 0 || scale_for_torques(motion) != 1) return std::nullopt;
  return motion;
}

JointMotion MotionPlanner::plan_stop(const JointState& state) const {
  constexpr double kStopJerkTime_s = 0.02;
  JointLimits limits = limits_;
  // A stop may be harsher than a motion: the distance that it saves matters more than its
  // smoothness.
  limits.jerk = limits.accel / kStopJerkTime_s;
  JointMotion stop;
  stop.plan_stop(state.q, state.qd, state.qdd, limits);
  return stop;
}

JointMotion MotionPlanner::plan_retreat(const JointVector& from, const JointVector& to) const {
  JointMove move{.start = from, .target = to, .limits = limits_, .maximum = limits_};
  // Slow, because the arm may still touch what it retreats from.
  move.time_scale = kRetreatScale;
  JointMotion retreat;
  retreat.plan(move);
  return retreat;
}

// ---- segments

Eigen::Isometry3d MotionPlanner::pose_in_base(const Pose& X_RT) const {
  const Pose unit{X_RT.p, X_RT.q.normalized()};
  return setup_->X_BR * unit.isometry();
}

Eigen::Isometry3d MotionPlanner::tool_pose(const JointVector& q,
                                           const Eigen::Isometry3d& X_FT) const {
  return flange_pose(setup_->model, q) * X_FT;
}

double MotionPlanner::range_distance(const JointVector& a, const JointVector& b) const {
  return ((a - b).array() / (limits_.upper - limits_.lower).array()).matrix().norm();
}

bool MotionPlanner::clear_of_limits(const JointVector& q) const {
  const auto middle = (limits_.upper + limits_.lower).array() / 2;
  const auto half = (limits_.upper - limits_.lower).array() / 2;
  return ((q.array() - middle).abs() <= kClearShare * half).all();
}

Result<JointVector> MotionPlanner::target_posture(const Eigen::Isometry3d& X_BF,
                                                  const JointVector& start) const {
  // The present elbow angle; a non-redundant arm has no other.
  const InverseKinematics& ik = *setup_->ik;
  // Redundancy resolution: keeping the elbow angle makes motions repeatable, and the cost is
  // bounded by kMaxDetour.
  const auto kept = ik.nearest(X_BF, start, ik.elbow_of(start));
  if (setup_->model.dof() <= 6) return kept;
  if (kept && range_distance(*kept, start) < kAtPose) return kept;
  // The best elbow angle, where the present one is close to a limit or far away.
  const auto elbow = ik.choose_elbow(X_BF, start);
  if (!elbow) return kept ? kept : tl::unexpected(elbow.error());
  const auto chosen = ik.nearest(X_BF, start, *elbow);
  if (!chosen) return kept;
  const bool keep = kept && clear_of_limits(*kept) &&
                    range_distance(*kept, start) <= kMaxDetour * range_distance(*chosen, start);
  return keep ? kept : chosen;
}

void MotionPlanner::add_joint_motion(const JointVector& target, const PlanStart& start,
                                     const ToolLimits& tool, const ToolLimits& maximum,
                                     MotionPlan& out) const {
  JointMove joints{.start = start.q, .target = target, .limits = limits_, .maximum = limits_};
  limit_tool_rates(joints, start.X_FT, tool, maximum);
  plan_joint_motion(joints, out.add().as_joint());
}

Result<void> MotionPlanner::add_line(const Eigen::Isometry3d& X_BT, const PlanStart& start,
                                     const ToolLimits& tool, const ToolLimits& tool_maximum,
                                     MotionPlan& out) const {
  PathMotion& path = out.add().as_path();
  ToolPath& tool_path = path.begin_tool_path(start.X_FT);
  const Eigen::Isometry3d X_BT_start = tool_pose(start.q, start.X_FT);
  const auto along = [&](const ToolLine& line) {
    SegmentLimits segment;
    tool_path.start(X_BT_start);
    tool_path.add_line(line, segment.add(line.length_m(), line.angle_rad(), tool, tool_maximum));
    return plan_path(segment.move(start.q, limits_), path);
  };
  // The shorter rotation, and for half a turn the other one where that fails.
  const ToolLine line(X_BT_start, X_BT);
  const Result<void> planned = along(line);
  if (planned || !line.half_turn()) return planned;
  return along(ToolLine(X_BT_start, X_BT, true)) ? Result<void>{} : planned;
}

/// The tool's velocity per unit of progress from the Jacobian at samples of the motion. The
/// acceleration limit leaves out the Jacobian's own change.
void MotionPlanner::limit_tool_rates(JointMove& move, const Eigen::Isometry3d& X_FT,
                                     const ToolLimits& tool, const ToolLimits& maximum) const {
  const JointVector delta = move.target - move.start;
  double trans = kLeastTravel, rot = kLeastTravel;  // per unit of progress
  for (int i = 0; i < kRateSamples; ++i) {
    const JointVector q = move.start + i / (kRateSamples - 1.0) * delta;
    // v = J dq/ds: the tool's velocity per unit of progress (Siciliano et al. 2009, sec. 3.1).
    const Eigen::Matrix<double, 6, 1> rate =
        point_jacobian(setup_->model, q, setup_->model.dof(), X_FT.translation()) * delta;
    trans = std::max(trans, rate.head<3>().norm());
    rot = std::max(rot, rate.tail<3>().norm());
  }
  const Eigen::Isometry3d X_BF = flange_pose(setup_->model, move.start);
  const Eigen::Isometry3d X_BF_target = flange_pose(setup_->model, move.target);
  const Eigen::Quaterniond turn(X_BF.linear().transpose() * X_BF_target.linear());
  // CRCL limits the net rotation of a free move. The rotation in between is only bounded by the
  // robot's own maximum.
  const double net = std::max(kLeastTravel, turn.angularDistance(Eigen::Quaterniond::Identity()));
  move.progress_speed = std::min(
      {tool.trans_speed_m_s / trans, tool.rot_speed_rad_s / net, maximum.rot_speed_rad_s / rot});
  move.progress_accel = std::min(
      {tool.trans_accel_m_s2 / trans, tool.rot_accel_rad_s2 / net, maximum.rot_accel_rad_s2 / rot});
}

double MotionPlanner::scale_for_torques(const JointMotion& motion) const {
  const auto position = [&motion](double t) {
    JointVector q;
    motion.at(t, q);
    return q;
  };
  return torque_scaling(setup_->model, setup_->payload, setup_->gravity_B, motion.duration(),
                        position);
}

/// A second plan with the time scale that the torques of the first require.
void MotionPlanner::plan_joint_motion(JointMove& move, JointMotion& motion) const {
  motion.plan(move);
  move.time_scale = scale_for_torques(motion);
  if (move.time_scale < 1) motion.plan(move);
}

Result<void> MotionPlanner::plan_path(const PathMove& move, PathMotion& path) const {
  if (auto ok = path.plan(arm(), move); !ok) return ok;
  const double scale =
      torque_scaling(setup_->model, setup_->payload, setup_->gravity_B, path.duration(),
                     [&path](double t) { return path.approximate_at(t); });
  if (scale < 1) path.set_time_scale(scale);
  return {};
}

}  // namespace aprsim::robot
