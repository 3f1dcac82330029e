#include "world/robot/trajectory/path_motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "world/robot/kinematics/kinematics.hpp"

namespace aprsim::robot {
namespace {

constexpr double kRests_m = 1e-9, kRests_rad = 1e-9;
/// Elbow turns to try when the straight way and the chosen elbow fail.
constexpr double kElbowSpacing = std::numbers::pi / 12;
/// Samples of a joint path: of each stretch between two edges of blends.
constexpr int kJointPathSteps = 12;

}  // namespace

PathMotion::PathMotion() {
  knots_.reserve(IkPath::kMaxSamples + 1);
  stretch_.reserve(IkPath::kMaxSamples + 1);
}

ToolPath& PathMotion::lay_tool_path(const Eigen::Isometry3d& X_FT) {
  of_joints_ = false;
  X_FT_ = X_FT;
  tool_path_.set_tool_frame(X_FT);
  return tool_path_.tool();
}

JointPath& PathMotion::lay_joint_path(const Eigen::Isometry3d& X_FT) {
  of_joints_ = true;
  X_FT_ = X_FT;
  return joint_path_;
}

const BlendedSegments& PathMotion::chain() const {
  return of_joints_ ? joint_path_.chain() : tool_path_.tool().chain();
}

std::span<const IkPath::Sample> PathMotion::samples() const {
  if (of_joints_) return joint_samples_;
  return tool_path_.samples();
}

JointVector PathMotion::position(const ArmGeometry& arm, double u) const {
  if (!of_joints_) return tool_path_.at(arm, u);
  return joint_path_.at(u >= 1 ? chain().length() : u * chain().length());
}

IkPath::Route PathMotion::route(const ArmGeometry& arm, const JointVector& start,
                                double elbow_turn_rad) const {
  return {
      .elbow_start_rad = arm.ik.elbow_of(start), .elbow_turn_rad = elbow_turn_rad, .start = start};
}

bool PathMotion::try_elbow(const ArmGeometry& arm, const JointVector& start,
                           double elbow_turn_rad) {
  const IkPath::Route way = route(arm, start, elbow_turn_rad);
  return tool_path_.looks_passable(arm, way) && tool_path_.trace(arm, way);
}

/// The elbow stays; else it turns to where the end pose suits it best; else to the nearest angle
/// that lets the whole path through.
Result<void> PathMotion::find_path(const ArmGeometry& arm, const PathMove& move) {
  const Result<void> first = tool_path_.trace(arm, route(arm, move.start, 0));
  if (first) return {};
  if (tool_path_.singular_start()) {
    const JointVector needed = tool_path_.needed_start();
    if (tool_rests(arm, move.start, needed) && tool_path_.trace(arm, route(arm, needed, 0))) {
      plan_turn(move, needed);
      return {};
    }
  }
  const auto chosen = arm.ik.choose_elbow(tool_path_.tool().end() * X_FT_.inverse(), move.start);
  if (!chosen) return tl::unexpected(chosen.error());  // the end itself is out of reach
  if (arm.model.dof() <= 6) return first;
  const double best = std::remainder(*chosen - arm.ik.elbow_of(move.start), 2 * std::numbers::pi);
  if (try_elbow(arm, move.start, best)) return {};
  for (double turn = kElbowSpacing; turn < std::numbers::pi; turn += kElbowSpacing) {
    if (try_elbow(arm, move.start, turn) || try_elbow(arm, move.start, -turn)) return {};
  }
  return first;
}

/// At a moderate pace: the tool's own limits say nothing about a turn that leaves it at rest.
void PathMotion::plan_turn(const PathMove& move, const JointVector& target) {
  constexpr double kTurnPace = 0.25;
  turn_.plan({.start = move.start,
              .target = target,
              .limits = move.joints,
              .maximum = move.joints,
              .pace = kTurnPace});
  turning_ = true;
}

bool PathMotion::tool_rests(const ArmGeometry& arm, const JointVector& from,
                            const JointVector& to) const {
  const Eigen::Isometry3d X_FB = flange_pose(arm.model, from).inverse();
  for (int i = 1; i <= 8; ++i) {
    const Eigen::Isometry3d X = X_FB * flange_pose(arm.model, from + i / 8.0 * (to - from));
    if (X.translation().norm() > kRests_m) return false;
    if ((X.linear() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() > kRests_rad) return false;
  }
  return true;
}

/// Postures and derivatives in closed form.
void PathMotion::sample_joint_path() {
  joint_samples_.clear();
  const BlendedSegments& chain = joint_path_.chain();
  const double length = chain.length();
  const auto add = [&](double s) {
    IkPath::Sample sample{s / length, joint_path_.at(s), {}, {}, {}};
    sample.slope = sample.curvature = sample.third_derivative = JointVector::Zero(sample.q.size());
    const auto [first, last] = chain.active(s);
    for (std::size_t i = first; i <= last; ++i) {
      const JointVector way = joint_path_.way(i);
      sample.slope += way * (chain.rate(i, s) * length);
      sample.curvature += way * (chain.curvature(i, s) * length * length);
      sample.third_derivative += way * (chain.third_derivative(i, s) * length * length * length);
    }
    joint_samples_.push_back(sample);
  };
  double s = 0;
  while (s < length) {
    const double edge = chain.next_break(s);
    for (int i = 0; i < kJointPathSteps; ++i) add(s + i * (edge - s) / kJointPathSteps);
    s = edge;
  }
  add(length);
}

Result<void> PathMotion::plan(const ArmGeometry& arm, const PathMove& move) {
  turning_ = braking_ = false;
  pace_ = speed_ = 1;
  if (of_joints_) {
    sample_joint_path();
  } else if (auto ok = find_path(arm, move); !ok) {
    return ok;
  }
  choose_limits(arm, move);
  set_pace(1);
  return {};
}

void PathMotion::set_pace(double pace) {
  pace_ = pace;
  restart(DoubleS::to_rest({0, 0, 0}, stretch_.length(), limits_now()));
  end_ = samples().back().q;
}

ScalarLimits PathMotion::limits_now() const {
  const double p = pace_;
  return {limits_.v * p * speed_, limits_.a * p * p, limits_.j * p * p * p};
}

void PathMotion::restart(const DoubleS& profile) {
  profile_ = profile;
  steps_ = 0;
  time_ = 0;
}

void PathMotion::set_speed(double fraction) {
  if (braking_ || fraction == speed_) return;
  speed_ = fraction;
  if (turning_) turn_.set_speed(fraction);
  const ScalarState here = profile_.at(time_);
  restart(fraction > 0 ? DoubleS::to_rest(here, stretch_.length(), limits_now())
                       : DoubleS::stop(here, limits_now()));
}

void PathMotion::brake(const ArmGeometry& arm, Brake how) {
  braking_ = true;
  if (turning_) {
    turn_.brake(how);
    end_ = turn_.end();
    restart(DoubleS());
    return;
  }
  restart(DoubleS::stop(profile_.at(time_), how == Brake::kHard ? hard_limits_ : limits_now()));
  end_ = position(arm, stretch_.u_at(profile_.end()));
}

JointVector PathMotion::roughly_at(double t) const {
  const double u = stretch_.u_at(profile_.at(t).s);
  if (!of_joints_) return tool_path_.interpolate(u);
  return joint_path_.at(u >= 1 ? chain().length() : u * chain().length());
}

bool PathMotion::advance(const ArmGeometry& arm, double dt, JointVector& q) {
  if (turning_) {
    if (!turn_.advance(dt, q)) return false;
    turning_ = false;
    return braking_;
  }
  time_ = static_cast<double>(++steps_) * dt;
  if (time_ < profile_.duration()) {
    q = position(arm, stretch_.u_at(profile_.at(time_).s));
    return false;
  }
  if (speed_ == 0 && !braking_) {  // waits on the path
    q = position(arm, stretch_.u_at(profile_.end()));
    return false;
  }
  q = end_;
  return true;
}

}  // namespace aprsim::robot
