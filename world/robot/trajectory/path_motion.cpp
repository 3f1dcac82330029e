#include "world/robot/trajectory/path_motion.hpp"

#include <array>
#include <cmath>
#include <numbers>

#include "world/robot/kinematics/dynamics.hpp"
#include "world/robot/trajectory/path/posture_search.hpp"

namespace aprsim::robot {
namespace {

constexpr double kRests_m = 1e-9, kRests_rad = 1e-9;
/// Spacing of the elbow turns to try when the kept and the chosen elbow angle fail.
constexpr double kElbowSpacing = std::numbers::pi / 12;
/// Numbers of elbow angles of a search over all postures, the quicker one first; the largest number
/// of excluded steps; and smoothing rounds of the guide, most first.
constexpr std::array kElbowAngles{72, 180};
constexpr int kMostForbidden = 6;
constexpr std::array kSmoothings{12, 3, 0};
/// A redundant arm that slows the tool down by more than kSlowed and loses more than kLost_s
/// searches other postures. They are used if the duration falls below the share kWorthwhile.
constexpr double kSlowed = 1.5, kLost_s = 1, kWorthwhile = 0.8;

IkPath::Route route(const ArmGeometry& arm, const JointVector& start, double elbow_turn_rad) {
  return {
      .elbow_start_rad = arm.ik.elbow_of(start), .elbow_turn_rad = elbow_turn_rad, .start = start};
}

/// Whether a straight motion in joint space is a self-motion: the flange does not move.
bool is_self_motion(const ArmGeometry& arm, const JointVector& from, const JointVector& to) {
  const Eigen::Isometry3d X_FB = flange_pose(arm.model, from).inverse();
  for (int i = 1; i <= 8; ++i) {
    const Eigen::Isometry3d X = X_FB * flange_pose(arm.model, from + i / 8.0 * (to - from));
    if (X.translation().norm() > kRests_m) return false;
    if ((X.linear() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() > kRests_rad) return false;
  }
  return true;
}

}  // namespace

ToolPath& PathMotion::begin_tool_path(const Eigen::Isometry3d& X_FT) {
  path_ = std::make_shared<Path>();
  path_->X_FT = X_FT;
  path_->ik.set_tool_frame(X_FT);
  return path_->ik.tool();
}

JointPath& PathMotion::begin_joint_path(const Eigen::Isometry3d& X_FT) {
  path_ = std::make_shared<Path>();
  path_->in_joint_space = true;
  path_->X_FT = X_FT;
  return path_->joint;
}

double PathMotion::length_s() const {
  return path_->in_joint_space ? path_->joint.segments().length()
                               : path_->ik.tool().segments().length();
}

std::span<const PathSample> PathMotion::samples() const {
  if (path_->in_joint_space) return path_->joint_samples;
  return path_->ik.samples();
}

JointVector PathMotion::position(const ArmGeometry& arm, double u) const {
  if (!path_->in_joint_space) return path_->ik.at(arm, u);
  return path_->joint.at(u >= 1 ? length_s() : u * length_s());
}

JointVector PathMotion::approximate(double u) const {
  if (!path_->in_joint_space) return path_->ik.interpolate(u);
  return path_->joint.at(u >= 1 ? length_s() : u * length_s());
}

JointVector PathMotion::approximate_at(double t) const {
  return approximate(path_->limits.scaling().u_at(profile_.at(t).s));
}

void PathMotion::sample(double interval_s, std::vector<JointVector>& out) const {
  if (in_self_motion_) self_motion_.sample(interval_s, out);
  for (double t = 0; t < duration(); t += interval_s) out.push_back(approximate_at(t));
  out.push_back(end_);
}

void PathMotion::remaining(std::size_t count, std::vector<JointVector>& out) const {
  if (in_self_motion_) self_motion_.remaining(count, out);
  if (in_self_motion_ && braking_) return;
  const double here = path_->limits.scaling().u_at(profile_.at(time_).s);
  const double end = braking_ ? path_->limits.scaling().u_at(profile_.end()) : 1;
  for (std::size_t i = 0; i <= count; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(count);
    out.push_back(approximate(here + share * (end - here)));
  }
}

// ---- planning

Result<void> PathMotion::plan(const ArmGeometry& arm, const PathMove& move) {
  in_self_motion_ = braking_ = false;
  time_scale_ = speed_ = 1;
  if (path_->in_joint_space) {
    path_->joint.sample(path_->joint_samples);
  } else if (auto ok = find_branch(arm, move); !ok) {
    return ok;
  }
  // The path's geometry is fixed first; timing then follows from derivatives of the joints along
  // it.
  path_->limits = choose_limits(arm, move);
  if (!path_->in_joint_space) prefer_quicker_postures(arm, move);
  set_time_scale(1);
  return {};
}

PathLimits PathMotion::choose_limits(const ArmGeometry& arm, const PathMove& move) const {
  PathLimits limits;
  limits.choose({.model = arm.model,
                 .X_FT = path_->X_FT,
                 .tool_path = path_->in_joint_space ? nullptr : &path_->ik.tool(),
                 .length_s = length_s(),
                 .samples = samples()},
                move);
  return limits;
}

void PathMotion::prefer_quicker_postures(const ArmGeometry& arm, const PathMove& move) {
  if (arm.model.dof() <= 6 || in_self_motion_) return;
  const auto duration = [](const PathLimits& limits) {
    // Durations of whole profiles are compared, because a local slowdown costs little on a long
    // line.
    return DoubleS::to_rest({0, 0, 0}, limits.scaling().length(), limits.planned()).duration();
  };
  const double slowed = path_->limits.scaling().length();
  const double lost_s = duration(path_->limits) * (1 - 1 / slowed);
  if (slowed < kSlowed || lost_s < kLost_s || !arm.may_search()) return;
  const IkPath first = path_->ik;
  PostureSearch search(arm, path_->ik.tool(), path_->ik.X_TF());
  const std::vector<JointVector> postures = search.find(move.start, kElbowAngles.front());
  if (!postures.empty() && try_guide(arm, postures)) {
    const PathLimits limits = choose_limits(arm, move);
    if (duration(limits) < kWorthwhile * duration(path_->limits)) {
      path_->limits = limits;
      return;
    }
  }
  path_->ik = first;
}

/// Keeps the elbow angle if possible. Else it changes along the path to the best one for the end
/// pose, or to the nearest one with which the whole path is feasible.
Result<void> PathMotion::find_branch(const ArmGeometry& arm, const PathMove& move) {
  // The present elbow angle.
  const Result<void> first = path_->ik.trace(arm, route(arm, move.start, 0));
  if (first) return {};
  // Example: a stretched wrist whose first and last axis coincide. The sum of both angles is given,
  // their difference is free.
  // From a singular start by a self-motion.
  if (path_->ik.singular_start()) {
    const JointVector required = path_->ik.required_start();
    if (is_self_motion(arm, move.start, required) &&
        path_->ik.trace(arm, route(arm, required, 0))) {
      plan_self_motion(move, required);
      return {};
    }
  }
  // Another elbow angle at the end.
  const auto chosen =
      arm.ik.choose_elbow(path_->ik.tool().end() * path_->X_FT.inverse(), move.start);
  if (!chosen) return tl::unexpected(chosen.error());  // the end itself is out of reach
  if (arm.model.dof() <= 6) return first;
  const double best = std::remainder(*chosen - arm.ik.elbow_of(move.start), 2 * std::numbers::pi);
  if (try_elbow_turn(arm, move.start, best)) return {};
  // Turns are tried in order of size, and both directions, so that the least change of the elbow
  // wins.
  for (double turn = kElbowSpacing; turn < std::numbers::pi; turn += kElbowSpacing) {
    if (try_elbow_turn(arm, move.start, turn) || try_elbow_turn(arm, move.start, -turn)) return {};
  }
  if (arm.may_search() && try_all_postures(arm, move.start)) return {};
  return first;
}

/// Tries any elbow angle, branch and full turn anywhere on the path.
bool PathMotion::try_all_postures(const ArmGeometry& arm, const JointVector& start) {
  for (const int elbow_angles : kElbowAngles) {
    PostureSearch search(arm, path_->ik.tool(), path_->ik.X_TF());
    for (int i = 0; i <= kMostForbidden; ++i) {
      const std::vector<JointVector> postures = search.find(start, elbow_angles);
      if (postures.empty()) break;
      if (try_guide(arm, postures)) return true;
      // The graph is coarse: a step that is feasible at its ends may pass a limit between them. It
      // is then excluded and the search repeated.
      search.forbid(path_->ik.reached());
    }
  }
  return false;
}

/// Traces the path along a guide, as smoothly as the limits allow.
bool PathMotion::try_guide(const ArmGeometry& arm, std::span<const JointVector> postures) {
  for (const int smoothings : kSmoothings) {
    const IkPath::Route guided{.start = postures.front(), .guide = {postures, smoothings}};
    if (path_->ik.trace(arm, guided)) return true;
  }
  return false;
}

bool PathMotion::try_elbow_turn(const ArmGeometry& arm, const JointVector& start,
                                double elbow_turn_rad) {
  const IkPath::Route turned = route(arm, start, elbow_turn_rad);
  return path_->ik.seems_feasible(arm, turned) && path_->ik.trace(arm, turned);
}

/// Moderate speed: the tool's limits do not bound a motion in which the tool rests.
void PathMotion::plan_self_motion(const PathMove& move, const JointVector& target) {
  constexpr double kSelfMotionScale = 0.25;
  self_motion_.plan({.start = move.start,
                     .target = target,
                     .limits = move.joints,
                     .maximum = move.joints,
                     .time_scale = kSelfMotionScale});
  in_self_motion_ = true;
}

// ---- profile

/// Every change is a new double-S profile from the present state, so that it stays on the path.
void PathMotion::restart(const DoubleS& profile) {
  profile_ = profile;
  steps_ = 0;
  time_ = 0;
}

ScalarLimits PathMotion::limits_now() const {
  const ScalarLimits& planned = path_->limits.planned();
  const double c = time_scale_;
  // Scaling of time by c scales the derivatives by c, c^2 and c^3.
  return {planned.v * c * speed_, planned.a * c * c, planned.j * c * c * c};
}

void PathMotion::set_time_scale(double scale) {
  time_scale_ = scale;
  restart(DoubleS::to_rest({0, 0, 0}, path_->limits.scaling().length(), limits_now()));
  end_ = samples().back().q;
}

void PathMotion::set_speed(double fraction) {
  if (braking_ || fraction == speed_) return;
  speed_ = fraction;
  if (in_self_motion_) self_motion_.set_speed(fraction);
  const ScalarState here = profile_.at(time_);
  restart(fraction > 0 ? DoubleS::to_rest(here, path_->limits.scaling().length(), limits_now())
                       : DoubleS::stop(here, limits_now()));
}

void PathMotion::brake(const ArmGeometry& arm, Brake how) {
  braking_ = true;
  if (in_self_motion_) {
    self_motion_.brake(how);
    end_ = self_motion_.end();
    restart(DoubleS());
    return;
  }
  restart(
      DoubleS::stop(profile_.at(time_), how == Brake::kHard ? path_->limits.hard() : limits_now()));
  end_ = position(arm, path_->limits.scaling().u_at(profile_.end()));
}

bool PathMotion::advance(const ArmGeometry& arm, double dt, JointVector& q) {
  if (in_self_motion_) {
    if (!self_motion_.advance(dt, q)) return false;
    in_self_motion_ = false;
    return braking_;
  }
  // Time from the count of steps: no drift.
  time_ = static_cast<double>(++steps_) * dt;
  if (time_ < profile_.duration()) {
    q = position(arm, path_->limits.scaling().u_at(profile_.at(time_).s));
    return false;
  }
  if (speed_ == 0 && !braking_) {  // waits on the path
    q = position(arm, path_->limits.scaling().u_at(profile_.end()));
    return false;
  }
  q = end_;
  return true;
}

void PathMotion::list(SharedParts& parts) const {
  if (!path_) return;
  parts[path_.get()] = sizeof(Path) + path_->ik.bytes() + path_->joint.bytes() +
                       bytes_of(path_->joint_samples) + path_->limits.scaling().bytes();
}

}  // namespace aprsim::robot
