#include "world/robot/line_motion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "world/robot/kinematics.hpp"

namespace aprsim::robot {
namespace {

/// Shares of a joint's acceleration for what the line takes at its rate, and for changing the
/// rate, where the line is slowed.
constexpr double kFollowShare = 0.75, kSlowShare = 0.25;
constexpr double kSmall = 1e-12;
constexpr double kRests_m = 1e-9, kRests_rad = 1e-9;
/// Elbow turns to try when the straight way and the chosen elbow fail.
constexpr double kElbowSpacing = std::numbers::pi / 12;

ScalarLimits paced(const ScalarLimits& l, double pace) {
  return {l.v * pace, l.a * pace * pace, l.j * pace * pace * pace};
}

/// Limits of the share of a line made per second: the slower of translation and rotation.
ScalarLimits share_limits(const ToolLine& line, const ToolLimits& tool) {
  const double length = std::max(line.length_m(), kSmall);
  const double angle = std::max(line.angle_rad(), kSmall);
  const double a = std::min(tool.trans_accel_m_s2 / length, tool.rot_accel_rad_s2 / angle);
  return {std::min(tool.trans_speed_m_s / length, tool.rot_speed_rad_s / angle), a,
          a / kJerkTime_s};
}

}  // namespace

LineMotion::LineMotion(const ArmModel& model, const InverseKinematics& ik,
                       const Eigen::Isometry3d& X_FT)
    : model_(model), ik_(ik), X_FT_(X_FT), path_(model, ik, X_FT) {
  knots_.reserve(LinePath::kMaxSamples + 1);
  stretch_.reserve(LinePath::kMaxSamples + 1);
}

LinePath::Route LineMotion::route(const LineMove& move, const JointVector& start,
                                  double elbow_turn_rad) const {
  const Eigen::Isometry3d X_BT_start = flange_pose(model_, start) * X_FT_;
  return {.line = ToolLine(X_BT_start, move.X_BT_end),
          .elbow_start_rad = ik_.elbow_of(start),
          .elbow_turn_rad = elbow_turn_rad,
          .start = start};
}

bool LineMotion::try_elbow(const LineMove& move, double elbow_turn_rad) {
  const LinePath::Route way = route(move, move.start, elbow_turn_rad);
  return path_.looks_passable(way) && path_.trace(way);
}

/// The elbow stays; else it turns to where the end pose suits it best; else to the nearest angle
/// that lets the whole line through.
Result<void> LineMotion::find_path(const LineMove& move) {
  const Result<void> first = path_.trace(route(move, move.start, 0));
  if (first) return {};
  if (path_.singular_start()) {
    const JointVector needed = path_.needed_start();
    if (tool_rests(move.start, needed) && path_.trace(route(move, needed, 0))) {
      plan_turn(move, needed);
      return {};
    }
  }
  const auto chosen = ik_.choose_elbow(move.X_BT_end * X_FT_.inverse(), move.start);
  if (!chosen) return tl::unexpected(chosen.error());  // the end itself is out of reach
  if (model_.dof() <= 6) return first;
  const double best = std::remainder(*chosen - ik_.elbow_of(move.start), 2 * std::numbers::pi);
  if (try_elbow(move, best)) return {};
  for (double turn = kElbowSpacing; turn < std::numbers::pi; turn += kElbowSpacing) {
    if (try_elbow(move, turn) || try_elbow(move, -turn)) return {};
  }
  return first;
}

/// At a moderate pace: the tool's own limits say nothing about a turn that leaves it at rest.
void LineMotion::plan_turn(const LineMove& move, const JointVector& target) {
  constexpr double kTurnPace = 0.25;
  turn_.plan({.start = move.start,
              .target = target,
              .limits = move.joints,
              .maximum = move.joints,
              .pace = kTurnPace});
  turning_ = true;
}

bool LineMotion::tool_rests(const JointVector& from, const JointVector& to) const {
  const Eigen::Isometry3d X_FB = flange_pose(model_, from).inverse();
  for (int i = 1; i <= 8; ++i) {
    const Eigen::Isometry3d X = X_FB * flange_pose(model_, from + i / 8.0 * (to - from));
    if (X.translation().norm() > kRests_m) return false;
    if ((X.linear() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() > kRests_rad) return false;
  }
  return true;
}

Result<void> LineMotion::plan(const LineMove& move) {
  turning_ = false;
  if (auto ok = find_path(move); !ok) return ok;
  choose_limits(move);
  set_pace(move.pace);
  return {};
}

void LineMotion::set_pace(double pace) {
  pace_ = pace;
  profile_ = DoubleS::to_rest({0, 0, 0}, stretch_.length(), paced(limits_, pace));
  end_ = path_.samples().back().q;
  steps_ = 0;
  time_ = 0;
}

/// Full rate where every joint keeps its speed and acceleration with it, else rates.
void LineMotion::choose_limits(const LineMove& move) {
  limits_ = share_limits(path_.route().line, move.tool);
  limits_.a = std::min(limits_.a, typical_accel(move.joints));
  limits_.j = limits_.a / kJerkTime_s;
  const double v = limits_.v, a = limits_.a;
  bool free = true;
  for (const LinePath::Sample& sample : path_.samples()) {
    const auto speed = sample.slope.cwiseAbs() * v;
    const auto acceleration = sample.bend.cwiseAbs() * v * v + sample.slope.cwiseAbs() * a;
    free = free && (speed.array() <= move.joints.speed.array()).all() &&
           (acceleration.array() <= move.joints.accel.array()).all();
  }
  stretch_.clear();
  if (!free) choose_rates(move.joints);
  const double tool_max = share_limits(path_.route().line, move.tool_max).a;
  hard_limits_.a = std::max(limits_.a, std::min(tool_max, spare_accel(move.joints)));
  hard_limits_.j = hard_limits_.a / kJerkTime_s;
}

/// The deceleration of the stretched parameter that the joints have left anywhere on the line.
double LineMotion::spare_accel(const JointLimits& joints) const {
  const double v = limits_.v;
  double spare = 1e9;
  for (const LinePath::Sample& sample : path_.samples()) {
    const double rate = stretch_.rate_of(sample.u);
    const double change = stretch_.stretched() ? kSlowShare : 0.0;
    const auto left =
        (1 - change) * joints.accel.array() - sample.bend.array().abs() * (v * v * rate * rate);
    spare = std::min(spare, (left / (sample.slope.array().abs() * rate + kSmall)).minCoeff());
  }
  return spare;
}

/// The acceleration of the line's parameter that the joints can follow over most of it.
double LineMotion::typical_accel(const JointLimits& joints) const {
  std::array<double, 17> found{};
  const auto samples = path_.samples();
  std::size_t at = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const double u = static_cast<double>(i) / static_cast<double>(found.size() - 1);
    while (at + 1 < samples.size() && samples[at].u < u) ++at;
    const auto slope = samples[at].slope.cwiseAbs().cwiseMax(kSmall);
    found[i] = kFollowShare * (joints.accel.array() / slope.array()).minCoeff();
  }
  std::nth_element(found.begin(), found.begin() + found.size() / 2, found.end());
  return found[found.size() / 2];
}

/// Rates that leave each joint its speed, and its acceleration in the shares above. Half of the
/// tool's acceleration goes to changes of the rate.
void LineMotion::choose_rates(const JointLimits& joints) {
  limits_.a *= 0.5;
  limits_.j *= 0.5;
  const double v = limits_.v, a = limits_.a;
  knots_.clear();
  for (const LinePath::Sample& sample : path_.samples()) {
    PathStretch::Knot knot{sample.u, 1, limits_.a / (v * v)};
    for (int i = 0; i < model_.dof(); ++i) {
      const double slope = std::max(std::abs(sample.slope(i)), kSmall);
      const double speed_rate = joints.speed(i) / (slope * v);
      // bend v^2 rate^2 + slope a rate = share of the acceleration
      const double p = std::abs(sample.bend(i)) * v * v, q = slope * a;
      const double r = kFollowShare * joints.accel(i);
      const double accel_rate = 2 * r / (q + std::sqrt(q * q + 4 * p * r));
      knot.rate = std::min({knot.rate, speed_rate, accel_rate});
      knot.slope = std::min(knot.slope, kSlowShare * joints.accel(i) / (slope * v * v));
    }
    knots_.push_back(knot);
  }
  stretch_.build(knots_);
}

void LineMotion::brake(Brake how) {
  if (turning_) {
    turn_.brake(how);
    end_ = turn_.end();
    profile_ = DoubleS();
    return;
  }
  profile_ =
      DoubleS::stop(profile_.at(time_), how == Brake::kHard ? hard_limits_ : paced(limits_, pace_));
  steps_ = 0;
  time_ = 0;
  end_ = path_.at(stretch_.u_at(profile_.end()));
}

JointVector LineMotion::roughly_at(double t) const {
  return path_.interpolate(stretch_.u_at(profile_.at(t).s));
}

JointVector LineMotion::at(double t) const {
  if (t >= profile_.duration()) return end_;
  return path_.at(stretch_.u_at(profile_.at(t).s));
}

bool LineMotion::advance(double dt, JointVector& q) {
  if (turning_) {
    if (turn_.advance(dt, q)) {
      turning_ = false;
      return profile_.duration() == 0;
    }
    return false;
  }
  time_ = static_cast<double>(++steps_) * dt;
  q = at(time_);
  return time_ >= profile_.duration();
}

}  // namespace aprsim::robot
