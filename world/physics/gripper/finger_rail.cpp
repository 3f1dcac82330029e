#include "world/physics/gripper/finger_rail.hpp"

#include <cmath>

namespace aprsim::physics {
namespace {

using Eigen::Vector3d;

// Sums run from the left, independent of Eigen's order: travels are part of the reproducible bits.

double dot(const Vector3d& a, const Vector3d& b) {
  return a.x() * b.x() + a.y() * b.y() + a.z() * b.z();
}

Vector3d rotated(const Eigen::Matrix3d& R, const Vector3d& v) {
  return {dot(R.row(0).transpose(), v), dot(R.row(1).transpose(), v), dot(R.row(2).transpose(), v)};
}

Vector3d rotated_back(const Eigen::Matrix3d& R, const Vector3d& v) {
  return {dot(R.col(0), v), dot(R.col(1), v), dot(R.col(2), v)};
}

/// Scaled by its largest element first, so that no square is lost.
Vector3d unit(const Vector3d& v) {
  Eigen::Index largest = 0;
  v.cwiseAbs().maxCoeff(&largest);
  const double scale = 1 / std::abs(v[largest]);
  double squared = 1;
  for (Eigen::Index i = 0; i < 3; ++i) {
    if (i != largest) squared += scale * v[i] * (scale * v[i]);
  }
  const double inverse = 1 / std::sqrt(squared);
  Vector3d out = inverse * (scale * v);
  out[largest] = std::copysign(inverse, v[largest]);
  return out;
}

}  // namespace

FingerRail::FingerRail(const RigidBody& finger, const RigidBody& palm, const Vector3d& closing_W)
    : axis_F_(rotated_back(finger.R_WB(), unit(closing_W))),
      open_P_(rotated_back(palm.R_WB(), finger.p_W() - palm.p_W())) {}

Vector3d FingerRail::axis_W(const RigidBody& finger) const {
  return rotated(finger.R_WB(), axis_F_);
}

FingerMotion FingerRail::motion(const RigidBody& finger, const RigidBody& palm) const {
  const Vector3d axis = axis_W(finger);
  const Vector3d travelled = finger.p_W() - rotated(palm.R_WB(), open_P_) - palm.p_W();
  return {.travel_m = dot(axis, travelled),
          .rate_m_s = dot(axis, finger.v_W()) - dot(axis, palm.v_W())};
}

void FingerRail::apply_force(RigidBody& finger, RigidBody& palm, double force_n) const {
  // Equal and opposite forces with equal torques conserve linear and angular momentum of the pair.
  const Vector3d force = force_n * axis_W(finger);
  const Vector3d torque = (0.5 * (palm.p_W() - finger.p_W())).cross(force);
  finger.add_load(force, torque);
  palm.add_load(-force, torque);
}

}  // namespace aprsim::physics
