#include "world/robot/trajectory/limits/path_limits.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "world/robot/kinematics/dynamics.hpp"
#include "world/robot/trajectory/path/ik_path.hpp"

// Limits of a path's parameter from limits of the joints, after Bobrow, Dubowsky & Gibson 1985,
// with limits of velocity, acceleration and jerk in the place of torques. Ours gives fixed shares
// of each limit to the path's derivatives and to changes of the rate, which is not time-optimal.

namespace aprsim::robot {
namespace {

/// Shares of a joint's acceleration: for the path at its rate, the least for changes of the rate,
/// and the most for both together.
constexpr double kPathShare = 0.75, kRateChangeShare = 0.25, kTotalShare = 0.95;
/// Shares of a joint's jerk: for the path's third derivative, and for its curvature while the rate
/// or, in a ramp, the speed changes.
constexpr double kThirdDerivativeShare = 0.4, kRateChangeJerkShare = 0.25, kRampJerkShare = 0.3;
/// Share of the tool's acceleration for a corner; the rest is for slowing down before it.
constexpr double kCornerShare = 0.8;
/// A path may exceed the jerk limits by this before it is slowed for them.
constexpr double kJerkTolerance = 1.25;
constexpr double kLeastRate = 1e-12;
/// The rate's slope changes over the way that the path makes in this time at full speed.
constexpr double kRateWindow_s = 0.12;

/// The tool's acceleration at full speed that comes from the path's curvature.
ToolPath::Curvature tool_curvature(const SampledPath& path, const PathSample& sample) {
  const double length = path.length_s;
  if (path.tool_path != nullptr) return path.tool_path->curvature(sample.u * length);
  const Eigen::Matrix<double, 6, 1> curvature =
      point_jacobian(path.model, sample.q, path.model.dof(), path.X_FT.translation()) *
      sample.curvature / (length * length);
  return {curvature.head<3>().norm(), curvature.tail<3>().norm()};
}

/// The acceleration of the path's parameter that the joints have at the median of the path.
double typical_accel(const SampledPath& path, const JointLimits& joints) {
  std::array<double, 17> found{};
  const auto points = path.samples;
  std::size_t at = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const double u = static_cast<double>(i) / static_cast<double>(found.size() - 1);
    while (at + 1 < points.size() && points[at].u < u) ++at;
    const auto slope = points[at].slope.cwiseAbs().cwiseMax(kLeastRate);
    found[i] = kPathShare * (joints.accel.array() / slope.array()).minCoeff();
  }
  std::nth_element(found.begin(), found.begin() + found.size() / 2, found.end());
  return found[found.size() / 2];
}

}  // namespace

/// Full rate where every joint and the tool keep their limits with it, else rates.
void PathLimits::choose(const SampledPath& path, const PathMove& move) {
  const double length = path.length_s;
  planned_.v = 1 / length;
  planned_.a = std::min(move.accel / length, typical_accel(path, move.joints));
  planned_.j = planned_.a / kJerkTime_s;
  scaling_.clear();
  if (!keeps_limits(path, move)) limit_rates(path, move);
  hard_.v = planned_.v;
  hard_.a =
      std::max(planned_.a, std::min(move.hard_accel / length, spare_accel(path, move.joints)));
  hard_.j = hard_.a / kJerkTime_s;
}

/// Whether a profile with these limits may accelerate or brake at u: a double-S ramp at either end.
bool PathLimits::in_ramp(double u) const {
  const double way = planned_.v * (planned_.v / planned_.a + planned_.a / planned_.j) / 2;
  return u < way || 1 - u < way;
}

bool PathLimits::keeps_limits(const SampledPath& path, const PathMove& move) const {
  const double v = planned_.v, a = planned_.a, j = planned_.j;
  for (const PathSample& sample : path.samples) {
    const auto slope = sample.slope.cwiseAbs().array(),
               curvature = sample.curvature.cwiseAbs().array();
    const auto third_derivative = sample.third_derivative.cwiseAbs().array();
    const double ramp = in_ramp(sample.u) ? 1 : 0;
    // Joint velocity, acceleration, jerk.
    if ((slope * v > move.joints.speed.array()).any()) return false;
    if ((curvature * v * v + slope * a > move.joints.accel.array()).any()) return false;
    const auto jerk = third_derivative * (v * v * v) + ramp * (curvature * (3 * v * a) + slope * j);
    if ((jerk > kJerkTolerance * move.joints.jerk.array()).any()) return false;
    // Centripetal acceleration of the tool.
    const ToolPath::Curvature tool = tool_curvature(path, sample);
    if (tool.trans > move.tool.trans_accel_m_s2 || tool.rot > move.tool.rot_accel_rad_s2) {
      return false;
    }
  }
  return true;
}

/// The deceleration of the scaled parameter that the path leaves to the joints all along it.
double PathLimits::spare_accel(const SampledPath& path, const JointLimits& joints) const {
  const double v = planned_.v;
  double spare = 1e9;
  for (const PathSample& sample : path.samples) {
    const double rate = scaling_.rate_of(sample.u);
    const double change = scaling_.active() ? kRateChangeShare : 0.0;
    const auto left = (1 - change) * joints.accel.array() -
                      sample.curvature.array().abs() * (v * v * rate * rate);
    spare = std::min(spare, (left / (sample.slope.array().abs() * rate + kLeastRate)).minCoeff());
  }
  return spare;
}

/// The highest rate and rate slope at one sample. In a corner and in a ramp half of the tool's
/// acceleration is left for changes of the rate; elsewhere all of it.
TimeScaling::RateLimit PathLimits::rate_limit(const SampledPath& path, const PathMove& move,
                                              const PathSample& sample) const {
  const double v = planned_.v, a = planned_.a;
  const ToolPath::Curvature tool = tool_curvature(path, sample);
  const bool ramp = in_ramp(sample.u);
  const bool straight = tool.trans < kLeastRate && tool.rot < kLeastRate;
  TimeScaling::RateLimit limit{sample.u, 1, (ramp || !straight ? a : 2 * a) / (v * v)};
  // Rate: the tool's centripetal acceleration.
  const double trans = kCornerShare * move.tool.trans_accel_m_s2 / (tool.trans + kLeastRate);
  const double rot = kCornerShare * move.tool.rot_accel_rad_s2 / (tool.rot + kLeastRate);
  limit.rate = std::min({limit.rate, std::sqrt(trans), std::sqrt(rot)});
  // Rate: velocity, acceleration and jerk of every joint.
  for (int i = 0; i < path.model.dof(); ++i) {
    const double slope = std::max(std::abs(sample.slope(i)), kLeastRate);
    const double curvature = std::max(std::abs(sample.curvature(i)), kLeastRate);
    const double third_derivative = std::max(std::abs(sample.third_derivative(i)), kLeastRate);
    const double speed_rate = move.joints.speed(i) / (slope * v);
    // Root of curvature v^2 rate^2 + slope a rate = share of the acceleration.
    const double p = curvature * v * v, q = slope * a;
    const double r = kPathShare * move.joints.accel(i);
    const double accel_rate = 2 * r / (q + std::sqrt(q * q + 4 * p * r));
    const double jerk = move.joints.jerk(i);
    const double jerk_rate =
        std::cbrt(kThirdDerivativeShare * jerk / (third_derivative * v * v * v));
    limit.rate = std::min({limit.rate, speed_rate, accel_rate, jerk_rate});
    if (ramp) {
      limit.rate = std::min(limit.rate, std::sqrt(kRampJerkShare * jerk / (3 * curvature * v * a)));
    }
  }
  // Slope of the rate: the remaining acceleration and jerk of every joint at that rate.
  for (int i = 0; i < path.model.dof(); ++i) {
    const double slope = std::max(std::abs(sample.slope(i)), kLeastRate);
    const double curvature = std::max(std::abs(sample.curvature(i)), kLeastRate);
    const double accel = move.joints.accel(i), rate = limit.rate;
    const double used = curvature * v * v * rate * rate + (ramp ? slope * a * rate : 0.0);
    const double left = std::max(kRateChangeShare * accel, kTotalShare * accel - used);
    limit.slope =
        std::min({limit.slope, left / (slope * v * v),
                  kRateChangeJerkShare * move.joints.jerk(i) / (3 * curvature * rate * v * v * v)});
  }
  return limit;
}

/// Half of the acceleration stays with the profile, half is for changes of the rate.
void PathLimits::limit_rates(const SampledPath& path, const PathMove& move) {
  planned_.a *= 0.5;
  planned_.j *= 0.5;
  std::vector<TimeScaling::RateLimit> limits;
  limits.reserve(path.samples.size());
  for (const PathSample& sample : path.samples) {
    limits.push_back(rate_limit(path, move, sample));
  }
  scaling_.build(limits, kRateWindow_s * planned_.v);
}

}  // namespace aprsim::robot
