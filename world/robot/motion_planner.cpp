#include "world/robot/motion_planner.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "world/robot/kinematics.hpp"
#include "world/robot/torque_pace.hpp"

namespace aprsim::robot {
namespace {

/// Of a joint's maximum, for joints that a command names without limits of their own.
constexpr double kJointSpeedShare = 0.25, kJointAccelShare = 0.5;
constexpr double kSmall = 1e-12;
constexpr double kAtLimit_rad = 1e-9;  ///< rounding of a limit that was meant exactly
constexpr double kUnitTolerance = 1e-3;
constexpr int kWaySamples = 33;
/// An elbow that stays must leave the joints within this share of their ranges, and must not cost
/// this much more joint motion than the best elbow.
constexpr double kComfortable = 0.98, kElbowPatience = 1.5;
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

Result<void> MotionPlanner::plan(const api::MoveTo& move, const JointVector& start,
                                 const ToolLimits& tool, const ToolLimits& tool_max,
                                 Motion& motion) const {
  if (auto ok = check_pose(move.X_RT); !ok) return ok;
  const Pose X_RT{move.X_RT.p, move.X_RT.q.normalized()};
  const Eigen::Isometry3d X_BT = setup_.X_BR * X_RT.isometry();
  if (move.straight) return plan_line(X_BT, start, tool, tool_max, motion);
  const auto target = free_target(X_BT * setup_.X_FT.inverse(), start);
  if (!target) return tl::unexpected(target.error());
  JointMove joints{.start = start, .target = *target, .limits = limits_, .maximum = limits_};
  cap_share(joints, tool);
  start_joint_motion(joints, motion);
  return {};
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
void MotionPlanner::cap_share(JointMove& move, const ToolLimits& tool) const {
  const JointVector way = move.target - move.start;
  double trans = kSmall, rot = kSmall;  // per share of the way
  for (int i = 0; i < kWaySamples; ++i) {
    const JointVector q = move.start + i / (kWaySamples - 1.0) * way;
    const Eigen::Matrix<double, 6, 1> rate =
        point_jacobian(setup_.model, q, setup_.model.dof(), setup_.X_FT.translation()) * way;
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

Result<void> MotionPlanner::plan_line(const Eigen::Isometry3d& X_BT, const JointVector& start,
                                      const ToolLimits& tool, const ToolLimits& tool_max,
                                      Motion& motion) const {
  LineMotion& line = motion.as_line();
  auto ok = line.plan(
      {.start = start, .X_BT_end = X_BT, .tool = tool, .tool_max = tool_max, .joints = limits_});
  if (!ok) return ok;
  const double pace = torque_pace(setup_.model, setup_.payload, setup_.gravity_B, line.duration(),
                                  [&line](double t) { return line.roughly_at(t); });
  if (pace < 1) line.set_pace(pace);
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
  return check_own_limit(joint, "acceleration", "rad/s^2", target.accel_rad_s2);
}

Result<void> MotionPlanner::plan(const api::MoveJoints& move, const JointVector& start,
                                 const ToolLimits& tool_max, JointVector& targets,
                                 Motion& motion) const {
  JointMove joints{.start = start, .target = targets, .limits = limits_, .maximum = limits_};
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
  cap_share(joints, tool_max);
  start_joint_motion(joints, motion);
  targets = joints.target;
  return {};
}

void MotionPlanner::plan_stop(const JointVector& q, const JointVector& qd, const JointVector& qdd,
                              Motion& motion) const {
  constexpr double kStopJerkTime_s = 0.02;
  JointLimits limits = limits_;
  limits.jerk = limits.accel / kStopJerkTime_s;
  motion.as_joint().plan_stop(q, qd, qdd, limits);
}

}  // namespace aprsim::robot
