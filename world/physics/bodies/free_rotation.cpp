#include "world/physics/bodies/free_rotation.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace aprsim::physics {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kMaxAngle = 0.05;  // [rad] of a substep: the fixed-point iteration contracts fast
constexpr double kLeastAngle = 1e-8;  // [rad] of a step
constexpr double kMaxSubsteps = 200;  // faster bodies have diverged
constexpr int kMaxIterations = 40;

/// Cayley transform: the rotation by 2 atan(|r|) about r, as a unit quaternion.
Quaterniond cayley(const Vector3d& r) {
  const double w = 1 / std::sqrt(1 + r.squaredNorm());
  return {w, w * r.x(), w * r.y(), w * r.z()};
}

/// One midpoint step. Sets the momentum in body axes to that at its end and returns the rotation
/// from the body axes at the end to those at the start.
Quaterniond midpoint_step(const Matrix3d& inverse_B, double step_s, Vector3d& momentum_B) {
  const Vector3d start = momentum_B;
  Vector3d half_turn = 0.5 * step_s * (inverse_B * start);
  Quaterniond rotation = cayley(half_turn);
  // Fixed point of the midpoint rule: the momentum at the end is the start's, seen from the axes
  // that turned at the mean momentum's rate. Its length is kept by every iterate, the energy by the
  // limit.
  for (int i = 0; i < kMaxIterations; ++i) {
    const Vector3d end = rotation.conjugate() * start;
    const Vector3d next = 0.25 * step_s * (inverse_B * (start + end));
    const bool converged = (next - half_turn).squaredNorm() <= 1e-34 * next.squaredNorm();
    half_turn = next;
    rotation = cayley(half_turn);
    if (converged) break;
  }
  momentum_B = rotation.conjugate() * start;
  return rotation;
}

/// The rotation vector of a unit quaternion, of at most half a turn.
Vector3d rotation_vector(const Quaterniond& q) {
  const double sine = q.vec().norm();
  if (sine == 0) return Vector3d::Zero();
  const double w = std::abs(q.w());
  const double angle = 2 * std::atan2(sine, w);
  return (q.w() < 0 ? -angle : angle) / sine * q.vec();
}

/// Whether z is an axis of symmetry of the inertia.
bool is_round(const Matrix3d& inertia_B) {
  const double z =
      std::abs(inertia_B(0, 1)) + std::abs(inertia_B(0, 2)) + std::abs(inertia_B(1, 2));
  return z == 0 && std::abs(inertia_B(0, 0) - inertia_B(1, 1)) <= 1e-15 * inertia_B(0, 0);
}

/// The motion of a symmetric top in closed form (Euler): a precession about the angular momentum,
/// and a spin about the axis of symmetry.
Quaterniond round_rotation(const Matrix3d& inertia_B, const Vector3d& omega_B, double step_s) {
  const double across = inertia_B(0, 0), along = inertia_B(2, 2);
  const double spin = (1 - along / across) * omega_B.z();
  const Vector3d precession_B = omega_B - Vector3d(0, 0, spin);
  return rotation_by(step_s * precession_B) * rotation_by({0, 0, step_s * spin});
}

}  // namespace

Quaterniond rotation_by(const Vector3d& turn) {
  constexpr double kSeries = 1e-3;  // [rad^2]; below, the series hold to rounding
  const double half2 = 0.25 * turn.squaredNorm();
  double sinc = 1 - half2 / 6 * (1 - half2 / 20 * (1 - half2 / 42 * (1 - half2 / 72)));
  double cosine = 1 - half2 / 2 * (1 - half2 / 12 * (1 - half2 / 30 * (1 - half2 / 56)));
  if (half2 > kSeries) {
    const double half = std::sqrt(half2);
    sinc = std::sin(half) / half;
    cosine = std::cos(half);
  }
  const Vector3d v = 0.5 * sinc * turn;
  return {cosine, v.x(), v.y(), v.z()};
}

Vector3d mean_free_omega(const Matrix3d& inertia_B, const Quaterniond& q_WB,
                         const Vector3d& omega_W, double step_s) {
  const Vector3d omega_B = q_WB.conjugate() * omega_W;
  Vector3d momentum_B = inertia_B * omega_B;
  // A rotation about a principal axis stays as it is, and in a step that hardly turns the body, the
  // change is below the rounding of what follows.
  const double angle = omega_W.norm() * step_s;
  if (angle < kLeastAngle || omega_B.cross(momentum_B).isZero(0)) return omega_W;
  if (is_round(inertia_B)) {
    return q_WB * (rotation_vector(round_rotation(inertia_B, omega_B, step_s)) / step_s);
  }
  const Matrix3d inverse_B = inertia_B.inverse();
  const int substeps = 1 + static_cast<int>(std::min(angle / kMaxAngle, kMaxSubsteps));
  // Weights of the triple jump: 1 / (2 - 2^(1/3)) twice, and the negative one between.
  static const double outer = 1 / (2 - std::cbrt(2.0));
  const std::array<double, 3> shares = {outer, 1 - 2 * outer, outer};
  Quaterniond turn_B = Quaterniond::Identity();
  for (int i = 0; i < substeps; ++i) {
    for (const double share : shares) {
      turn_B = turn_B * midpoint_step(inverse_B, share * step_s / substeps, momentum_B);
    }
  }
  return q_WB * (rotation_vector(turn_B) / step_s);
}

}  // namespace aprsim::physics
