#include "world/robot/planning/motion_planner.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "world/robot/kinematics/kinematics.hpp"
#include "world/robot/trajectory/torque_scaling.hpp"

namespace aprsim::robot {
namespace {

/// Of a joint's maximum, for joints that a command names without limits of their own.
constexpr double kJointSpeedShare = 0.25, kJointAccelShare = 0.5;
constexpr double kLeastTravel = 1e-12;
constexpr double kAtLimit_rad = 1e-9;  ///< rounding of a limit that was meant exactly
constexpr double kUnitTolerance = 1e-3;
constexpr int kWaySamples = 33;
/// An elbow that stays must leave the joints within this share of their ranges, and must not cost
/// this much more joint motion than the best elbow.
constexpr double kComfortable = 0.98, kElbowPatience = 1.5;
/// Of a joint's speed, for joints that have hardly any way but must slow down and come back.
constexpr double kPassingSpeed = 0.05;
constexpr double kRetreatPace = 0.3;
constexpr double kThere = 1e-6;  ///< of the joint ranges: the arm is at the pose already

std::string limit_text(const Joint& joint, double q) {
  const double unit = 180 / std::numbers::pi;
  const bool below = q < joint.lower_rad;
  const double limit = (below ? joint.lower_rad : joint.upper_rad) * unit;
  const int digits = std::abs(q * unit - limit) < 0.1 ? 6 : 1;
  char text[160];
  std::snprintf(text, sizeof text, "%s at %.*f deg is %s than its limit %.*f deg",
                joint.name.c_str(), digits, q * unit, below ? "less" : "greater", digits, limit);
  return text;
}

Result<void> check_pose(const Pose& pose) {
  if (!pose.p.allFinite() || !pose.q.coeffs().allFinite()) {
    return fail(ErrorCode::kInvalidArgument, "pose", "the pose is not a number");
  }
  if (std::abs(pose.q.norm() - 1) > kUnitTolerance) {
    char text[120];
    std::snprintf(text, sizeof text, "the rotation's quaternion has norm %g, it must be 1",
                  pose.q.norm());
    return fail(ErrorCode::kInvalidArgument, "pose", text);
  }
  return {};
}

Result<void> check_own_limit(const Joint& joint, const char* what, const char* unit,
                             const std::optional<double>& value) {
  if (!value || (*value > 0 && std::isfinite(*value))) return {};
  char text[160];
  std::snprintf(text, sizeof text, "%s: %s %g %s must be greater than 0", joint.name.c_str(), what,
                *value, unit);
  return fail(ErrorCode::kInvalidArgument, joint.name, text);
}

}  // namespace

MotionPlanner::MotionPlanner(const ControllerSetup& setup)
    : setup_(setup), limits_(derive_joint_limits(setup.model, setup.payload, setup.gravity_B)) {}

Result<Eigen::Isometry3d> MotionPlanner::pose_in_base(const Pose& X_RT) const {
  if (auto ok = check_pose(X_RT); !ok) return tl::unexpected(ok.error());
  const Pose unit{X_RT.p, X_RT.q.normalized()};
  return setup_.X_BR * unit.isometry();
}

Result<void> MotionPlanner::plan(const api::MoveTo& move, const PlanStart& start,
                                 const ToolLimitSettings& limits, MotionSequence& out) const {
  out.clear();
  const auto X_BT = pose_in_base(move.X_RT);
  if (!X_BT) return tl::unexpected(X_BT.error());
  const ToolLimits tool = limits.effective(move.limits);
  if (!move.straight) {
    const auto target = free_target(*X_BT * start.X_FT.inverse(), start.q);
    if (!target) return tl::unexpected(target.error());
    plan_free(*target, start, tool, out);
    return {};
  }
  return plan_line(*X_BT, start, tool, limits.maximum(), out);
}

void MotionPlanner::plan_free(const JointVector& target, const PlanStart& start,
                              const ToolLimits& tool, MotionSequence& out) const {
  JointMove joints{.start = start.q, .target = target, .limits = limits_, .maximum = limits_};
  cap_share(joints, start.X_FT, tool);
  start_joint_motion(joints, out.add());
}

double MotionPlanner::range_distance(const JointVector& a, const JointVector& b) const {
  return ((a - b).array() / (limits_.upper - limits_.lower).array()).matrix().norm();
}

bool MotionPlanner::comfortable(const JointVector& q) const {
  const auto middle = (limits_.upper + limits_.lower).array() / 2;
  const auto half = (limits_.upper - limits_.lower).array() / 2;
  return ((q.array() - middle).abs() <= kComfortable * half).all();
}

/// The nearest posture. A redundant arm keeps its elbow where that is nearly as near.
Result<JointVector> MotionPlanner::free_target(const Eigen::Isometry3d& X_BF,
                                               const JointVector& start) const {
  const InverseKinematics& ik = *setup_.ik;
  const auto kept = ik.nearest(X_BF, start, ik.elbow_of(start));
  if (setup_.model.dof() <= 6) return kept;
  if (kept && range_distance(*kept, start) < kThere) return kept;
  const auto elbow = ik.choose_elbow(X_BF, start);
  if (!elbow) return kept ? kept : tl::unexpected(elbow.error());
  const auto chosen = ik.nearest(X_BF, start, *elbow);
  if (!chosen) return kept;
  const bool keep = kept && comfortable(*kept) &&
                    range_distance(*kept, start) <= kElbowPatience * range_distance(*chosen, start);
  return keep ? kept : chosen;
}

/// Limits the shared profile so that the tool keeps its speeds and accelerations along the way.
void MotionPlanner::cap_share(JointMove& move, const Eigen::Isometry3d& X_FT,
                              const ToolLimits& tool) const {
  const JointVector way = move.target - move.start;
  double trans = kLeastTravel, rot = kLeastTravel;  // per share of the way
  for (int i = 0; i < kWaySamples; ++i) {
    const JointVector q = move.start + i / (kWaySamples - 1.0) * way;
    const Eigen::Matrix<double, 6, 1> rate =
        point_jacobian(setup_.model, q, setup_.model.dof(), X_FT.translation()) * way;
    trans = std::max(trans, rate.head<3>().norm());
    rot = std::max(rot, rate.tail<3>().norm());
  }
  move.share_speed = std::min(tool.trans_speed_m_s / trans, tool.rot_speed_rad_s / rot);
  move.share_accel = std::min(tool.trans_accel_m_s2 / trans, tool.rot_accel_rad_s2 / rot);
}

void MotionPlanner::start_joint_motion(JointMove& move, Motion& motion) const {
  JointMotion& joints = motion.as_joint();
  joints.plan(move);
  const auto position = [&joints](double t) {
    JointVector q;
    joints.at(t, q);
    return q;
  };
  move.pace =
      torque_pace(setup_.model, setup_.payload, setup_.gravity_B, joints.duration(), position);
  if (move.pace < 1) joints.plan(move);
}

Result<void> MotionPlanner::start_path(const PathMove& move, PathMotion& path) const {
  if (auto ok = path.plan(arm(), move); !ok) return ok;
  const double pace = torque_pace(setup_.model, setup_.payload, setup_.gravity_B, path.duration(),
                                  [&path](double t) { return path.roughly_at(t); });
  if (pace < 1) path.set_pace(pace);
  return {};
}

Result<void> MotionPlanner::check(const api::JointTarget& target) const {
  const int dof = setup_.model.dof();
  if (target.joint < 0 || target.joint >= dof) {
    return fail(ErrorCode::kInvalidArgument, "joint",
                "joint number " + std::to_string(target.joint + 1) + " does not exist: " +
                    setup_.model.name + " has joints 1 to " + std::to_string(dof));
  }
  const Joint& joint = setup_.model.joints[static_cast<std::size_t>(target.joint)];
  if (!std::isfinite(target.position_rad)) {
    return fail(ErrorCode::kInvalidArgument, joint.name,
                joint.name + ": the position is not a number");
  }
  if (target.position_rad < joint.lower_rad - kAtLimit_rad ||
      target.position_rad > joint.upper_rad + kAtLimit_rad) {
    return fail(ErrorCode::kUnreachable, joint.name, limit_text(joint, target.position_rad));
  }
  if (auto ok = check_own_limit(joint, "speed", "rad/s", target.speed_rad_s); !ok) return ok;
  if (auto ok = check_own_limit(joint, "acceleration", "rad/s^2", target.accel_rad_s2); !ok) {
    return ok;
  }
  return target.torque ? check_torque(joint, *target.torque) : Result<void>{};
}

Result<void> MotionPlanner::check_torque(const Joint& joint, const api::JointTorque& torque) const {
  if (auto ok = check_own_limit(joint, "torque", "Nm", torque.setting_nm); !ok) return ok;
  if (auto ok = check_own_limit(joint, "torque change rate", "Nm/s", torque.rate_nm_s); !ok) {
    return ok;
  }
  if (torque.setting_nm <= joint.max_torque_nm) return {};
  char text[160];
  std::snprintf(text, sizeof text, "%s: torque %g Nm is greater than its limit %g Nm",
                joint.name.c_str(), torque.setting_nm, joint.max_torque_nm);
  return fail(ErrorCode::kInvalidArgument, joint.name, text);
}

Result<void> MotionPlanner::plan(const api::MoveJoints& move, const PlanStart& start,
                                 const ToolLimitSettings& limits, JointVector& targets,
                                 MotionSequence& out) const {
  out.clear();
  JointMove joints{.start = start.q, .target = targets, .limits = limits_, .maximum = limits_};
  joints.limits.speed *= kJointSpeedShare;
  joints.limits.accel *= kJointAccelShare;
  std::array<bool, kMaxDof> named{};
  for (const api::JointTarget& target : move.targets) {
    if (auto ok = check(target); !ok) return ok;
    const int i = target.joint;
    const auto slot = static_cast<std::size_t>(i);
    if (named[slot]) {
      return fail(ErrorCode::kInvalidArgument, setup_.model.joints[slot].name,
                  setup_.model.joints[slot].name + " is named twice");
    }
    named[slot] = true;
    if (target.torque) {
      joints.target(i) = start.q(i);
      continue;
    }
    joints.target(i) = std::clamp(target.position_rad, limits_.lower(i), limits_.upper(i));
    joints.alone[slot] = target.speed_rad_s || target.accel_rad_s2;
    if (target.speed_rad_s) {
      joints.limits.speed(i) = std::min(*target.speed_rad_s, limits_.speed(i));
    }
    if (target.accel_rad_s2) {
      joints.limits.accel(i) = std::min(*target.accel_rad_s2, limits_.accel(i));
    }
  }
  joints.limits.jerk = joints.limits.accel / kJerkTime_s;
  cap_share(joints, start.X_FT, limits.maximum());
  start_joint_motion(joints, out.add());
  targets = joints.target;
  return {};
}

/// Every joint from its state to its target by itself, at speeds in the proportion of the ways, so
/// that they arrive nearly together.
bool MotionPlanner::blend_from_motion(const PassingState& passing, const PlanStart& start,
                                      const ToolLimits& tool, MotionSequence& out) const {
  const JointMotion* planned = out.now().joint();
  if (planned == nullptr) return false;
  const JointMotion from_rest = *planned;
  JointMove move = from_rest.move();
  move.start = passing.q;
  move.qd = passing.qd;
  move.qdd = passing.qdd;
  move.pace = 1;
  cap_share(move, start.X_FT, tool);
  const Jacobian J =
      point_jacobian(setup_.model, passing.q, setup_.model.dof(), start.X_FT.translation());
  for (int i = 0; i < setup_.model.dof(); ++i) {
    const double way = std::abs(move.target(i) - move.start(i));
    const double lever = std::max(J.col(i).head<3>().norm(), kLeastTravel);
    const double least_speed = std::max(std::abs(move.qd(i)), kPassingSpeed * limits_.speed(i));
    const double least_accel = 0.5 * tool.trans_accel_m_s2 / lever;
    move.limits.speed(i) =
        std::min(move.limits.speed(i), std::max(move.share_speed * way, least_speed));
    move.limits.accel(i) =
        std::min(move.limits.accel(i), std::max(move.share_accel * way, least_accel));
    move.limits.jerk(i) = limits_.jerk(i);
  }
  JointMotion& joints = out.now().as_joint();
  joints.plan(move);
  const auto give_up = [&] {
    joints = from_rest;
    return false;
  };
  if (joints.beyond_range() > 0) return give_up();
  const auto position = [&joints](double t) {
    JointVector q;
    joints.at(t, q);
    return q;
  };
  const double pace =
      torque_pace(setup_.model, setup_.payload, setup_.gravity_B, joints.duration(), position);
  return pace == 1 || give_up();
}

void MotionPlanner::plan_stop(const PassingState& passing, MotionSequence& out) const {
  constexpr double kStopJerkTime_s = 0.02;
  JointLimits limits = limits_;
  limits.jerk = limits.accel / kStopJerkTime_s;
  out.clear();
  out.add().as_joint().plan_stop(passing.q, passing.qd, passing.qdd, limits);
}

void MotionPlanner::plan_retreat(const JointVector& from, const JointVector& to,
                                 MotionSequence& out) const {
  JointMove move{.start = from, .target = to, .limits = limits_, .maximum = limits_};
  move.pace = kRetreatPace;
  out.clear();
  out.add().as_joint().plan(move);
}

}  // namespace aprsim::robot
