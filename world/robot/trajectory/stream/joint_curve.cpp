#include "world/robot/trajectory/stream/joint_curve.hpp"

#include <algorithm>
#include <cmath>

namespace aprsim::robot {
namespace {

constexpr int kSamples = 16;  ///< of a quintic curve

}  // namespace

JointCurve::JointCurve(const CurvePoint& from, const CurvePoint& to)
    : duration_(seconds(to.time - from.time)), degree_(1) {
  const double T = duration_;
  const JointVector slope = (to.q - from.q) / T;
  auto& c = coefficients_;
  c[0] = from.q;
  c[1] = slope;
  if (from.qd.size() == 0 || to.qd.size() == 0) return;
  c[1] = from.qd;
  if (from.qdd.size() == 0 || to.qdd.size() == 0) {
    // Cubic Hermite polynomial in powers of t.
    degree_ = 3;
    c[2] = (3 * slope - 2 * from.qd - to.qd) / T;
    c[3] = (from.qd + to.qd - 2 * slope) / (T * T);
    return;
  }
  // Quintic polynomial through both states (Biagiotti & Melchiorri 2008, sec. 2.1.6).
  degree_ = 5;
  c[2] = from.qdd / 2;
  c[3] = (20 * slope - 8 * to.qd - 12 * from.qd - (3 * from.qdd - to.qdd) * T) / (2 * T * T);
  c[4] =
      (-30 * slope + 14 * to.qd + 16 * from.qd + (3 * from.qdd - 2 * to.qdd) * T) / (2 * T * T * T);
  c[5] = (12 * slope - 6 * (to.qd + from.qd) + (to.qdd - from.qdd) * T) / (2 * T * T * T * T);
}

JointState JointCurve::at(double t) const {
  // Horner's scheme for the polynomial and both derivatives.
  const auto& c = coefficients_;
  JointState state{c[static_cast<std::size_t>(degree_)], JointVector::Zero(c[0].size()),
                   JointVector::Zero(c[0].size())};
  for (int k = degree_ - 1; k >= 0; --k) {
    state.qdd = state.qdd * t + 2 * state.qd;
    state.qd = state.qd * t + state.q;
    state.q = state.q * t + c[static_cast<std::size_t>(k)];
  }
  return state;
}

double JointCurve::position(int joint, double t) const {
  double q = coefficient(degree_, joint);
  for (int k = degree_ - 1; k >= 0; --k) q = q * t + coefficient(k, joint);
  return q;
}

double JointCurve::speed(int joint, double t) const {
  double qd = degree_ * coefficient(degree_, joint);
  for (int k = degree_ - 1; k >= 1; --k) qd = qd * t + k * coefficient(k, joint);
  return qd;
}

void JointCurve::include(int joint, double t, Extent& extent) const {
  if (!(t > 0 && t < duration_)) return;
  const double q = position(joint, t);
  extent.lowest = std::min(extent.lowest, q);
  extent.highest = std::max(extent.highest, q);
  extent.speed = std::max(extent.speed, std::abs(speed(joint, t)));
}

JointCurve::Extent JointCurve::extent(int joint) const {
  const double ends[] = {position(joint, 0), position(joint, duration_)};
  Extent extent{std::min(ends[0], ends[1]), std::max(ends[0], ends[1]),
                std::max(std::abs(speed(joint, 0)), std::abs(speed(joint, duration_)))};
  if (degree_ == 3) {
    // The speed is extreme where the acceleration 2 c2 + 6 c3 t is zero, the position where the
    // velocity c1 + 2 c2 t + 3 c3 t^2 is.
    const double c1 = coefficient(1, joint), c2 = coefficient(2, joint), c3 = coefficient(3, joint);
    include(joint, -c2 / (3 * c3), extent);
    const double discriminant = c2 * c2 - 3 * c1 * c3;
    if (discriminant < 0) return extent;
    // Numerically stable roots of the quadratic (Press et al. 2007, sec. 5.6).
    const double r = -(c2 + std::copysign(std::sqrt(discriminant), c2));
    include(joint, r / (3 * c3), extent);
    include(joint, c1 / r, extent);
  } else if (degree_ == 5) {
    for (int k = 1; k < kSamples; ++k) include(joint, duration_ * k / kSamples, extent);
  }
  return extent;
}

}  // namespace aprsim::robot
