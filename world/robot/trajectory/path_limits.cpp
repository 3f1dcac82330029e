#include <algorithm>
#include <array>
#include <cmath>

#include "world/robot/kinematics/kinematics.hpp"
#include "world/robot/trajectory/path_motion.hpp"

namespace aprsim::robot {
namespace {

/// Shares of a joint's acceleration for what the path takes at its rate, and the least for changing
/// the rate, where the path is slowed; together they take no more than the last. Those of its jerk
/// likewise: for the path's own third derivative, and for its curvature while the rate or the speed
/// changes.
constexpr double kFollowShare = 0.75, kSlowShare = 0.25, kWholeShare = 0.95;
constexpr double kTwistShare = 0.4, kSlowJerkShare = 0.25, kRunUpJerkShare = 0.3;
/// Share of the tool's acceleration that a corner takes; slowing down for it takes the rest.
constexpr double kCornerShare = 0.8;
/// A path may exceed the jerk limits by this before it is slowed for them.
constexpr double kJerkPatience = 1.25;
constexpr double kLeastRate = 1e-12;
/// The rate's slope changes over what the path does in this time at full speed.
constexpr double kRateWindow_s = 0.12;

}  // namespace

/// The tool's acceleration at full speed that comes from the path's curvature.
ToolPath::Curvature PathMotion::tool_bend(const ArmGeometry& arm,
                                          const IkPath::Sample& sample) const {
  const double length = chain().length();
  if (!of_joints_) return tool_path_.tool().curvature(sample.u * length);
  const Eigen::Matrix<double, 6, 1> curvature =
      point_jacobian(arm.model, sample.q, arm.model.dof(), X_FT_.translation()) * sample.curvature /
      (length * length);
  return {curvature.head<3>().norm(), curvature.tail<3>().norm()};
}

/// Full rate where every joint and the tool keep their limits with it, else rates.
void PathMotion::choose_limits(const ArmGeometry& arm, const PathMove& move) {
  const double length = chain().length();
  limits_.v = 1 / length;
  limits_.a = std::min(move.accel / length, typical_accel(move.joints));
  limits_.j = limits_.a / kJerkTime_s;
  stretch_.clear();
  if (!runs_free(arm, move)) choose_rates(arm, move);
  hard_limits_.v = limits_.v;
  hard_limits_.a =
      std::max(limits_.a, std::min(move.hard_accel / length, spare_accel(move.joints)));
  hard_limits_.j = hard_limits_.a / kJerkTime_s;
}

/// Whether a profile with these limits runs up or down at u.
bool PathMotion::runs_up(double u) const {
  const double way = limits_.v * (limits_.v / limits_.a + limits_.a / limits_.j) / 2;
  return u < way || 1 - u < way;
}

bool PathMotion::runs_free(const ArmGeometry& arm, const PathMove& move) const {
  const double v = limits_.v, a = limits_.a, j = limits_.j;
  for (const IkPath::Sample& sample : samples()) {
    const auto slope = sample.slope.cwiseAbs().array(),
               curvature = sample.curvature.cwiseAbs().array();
    const auto third_derivative = sample.third_derivative.cwiseAbs().array();
    const double run_up = runs_up(sample.u) ? 1 : 0;
    if ((slope * v > move.joints.speed.array()).any()) return false;
    if ((curvature * v * v + slope * a > move.joints.accel.array()).any()) return false;
    const auto jerk =
        third_derivative * (v * v * v) + run_up * (curvature * (3 * v * a) + slope * j);
    if ((jerk > kJerkPatience * move.joints.jerk.array()).any()) return false;
    const ToolPath::Curvature tool = tool_bend(arm, sample);
    if (tool.trans > move.tool.trans_accel_m_s2 || tool.rot > move.tool.rot_accel_rad_s2) {
      return false;
    }
  }
  return true;
}

/// The deceleration of the stretched parameter that the joints have left anywhere on the path.
double PathMotion::spare_accel(const JointLimits& joints) const {
  const double v = limits_.v;
  double spare = 1e9;
  for (const IkPath::Sample& sample : samples()) {
    const double rate = stretch_.rate_of(sample.u);
    const double change = stretch_.stretched() ? kSlowShare : 0.0;
    const auto left = (1 - change) * joints.accel.array() -
                      sample.curvature.array().abs() * (v * v * rate * rate);
    spare = std::min(spare, (left / (sample.slope.array().abs() * rate + kLeastRate)).minCoeff());
  }
  return spare;
}

/// The acceleration of the path's parameter that the joints can follow over most of it.
double PathMotion::typical_accel(const JointLimits& joints) const {
  std::array<double, 17> found{};
  const auto points = samples();
  std::size_t at = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const double u = static_cast<double>(i) / static_cast<double>(found.size() - 1);
    while (at + 1 < points.size() && points[at].u < u) ++at;
    const auto slope = points[at].slope.cwiseAbs().cwiseMax(kLeastRate);
    found[i] = kFollowShare * (joints.accel.array() / slope.array()).minCoeff();
  }
  std::nth_element(found.begin(), found.begin() + found.size() / 2, found.end());
  return found[found.size() / 2];
}

/// What the joints and the tool allow at one sample. In a corner, and where the profile runs up,
/// half of the tool's acceleration is left for changes of the rate; elsewhere all of it.
TimeScaling::Knot PathMotion::knot_at(const ArmGeometry& arm, const PathMove& move,
                                      const IkPath::Sample& sample) const {
  const double v = limits_.v, a = limits_.a;
  const ToolPath::Curvature tool = tool_bend(arm, sample);
  const bool run_up = runs_up(sample.u);
  const bool straight = tool.trans < kLeastRate && tool.rot < kLeastRate;
  TimeScaling::Knot knot{sample.u, 1, (run_up || !straight ? a : 2 * a) / (v * v)};
  const double trans = kCornerShare * move.tool.trans_accel_m_s2 / (tool.trans + kLeastRate);
  const double rot = kCornerShare * move.tool.rot_accel_rad_s2 / (tool.rot + kLeastRate);
  knot.rate = std::min({knot.rate, std::sqrt(trans), std::sqrt(rot)});
  for (int i = 0; i < arm.model.dof(); ++i) {
    const double slope = std::max(std::abs(sample.slope(i)), kLeastRate);
    const double curvature = std::max(std::abs(sample.curvature(i)), kLeastRate);
    const double third_derivative = std::max(std::abs(sample.third_derivative(i)), kLeastRate);
    const double speed_rate = move.joints.speed(i) / (slope * v);
    // curvature v^2 rate^2 + slope a rate = share of the acceleration
    const double p = curvature * v * v, q = slope * a;
    const double r = kFollowShare * move.joints.accel(i);
    const double accel_rate = 2 * r / (q + std::sqrt(q * q + 4 * p * r));
    const double jerk = move.joints.jerk(i);
    const double twist_rate = std::cbrt(kTwistShare * jerk / (third_derivative * v * v * v));
    knot.rate = std::min({knot.rate, speed_rate, accel_rate, twist_rate});
    if (run_up) {
      knot.rate = std::min(knot.rate, std::sqrt(kRunUpJerkShare * jerk / (3 * curvature * v * a)));
    }
  }
  for (int i = 0; i < arm.model.dof(); ++i) {
    const double slope = std::max(std::abs(sample.slope(i)), kLeastRate);
    const double curvature = std::max(std::abs(sample.curvature(i)), kLeastRate);
    const double accel = move.joints.accel(i), rate = knot.rate;
    const double taken = curvature * v * v * rate * rate + (run_up ? slope * a * rate : 0.0);
    const double left = std::max(kSlowShare * accel, kWholeShare * accel - taken);
    knot.slope =
        std::min({knot.slope, left / (slope * v * v),
                  kSlowJerkShare * move.joints.jerk(i) / (3 * curvature * rate * v * v * v)});
  }
  return knot;
}

void PathMotion::choose_rates(const ArmGeometry& arm, const PathMove& move) {
  limits_.a *= 0.5;
  limits_.j *= 0.5;
  knots_.clear();
  for (const IkPath::Sample& sample : samples()) knots_.push_back(knot_at(arm, move, sample));
  stretch_.build(knots_, kRateWindow_s * limits_.v);
}

}  // namespace aprsim::robot
