#include "world/physics/bodies/rigid_body.hpp"

#include <cassert>
#include <cmath>

#include <Eigen/LU>

namespace aprsim::physics {
namespace {

/// Rotation matrix of a unit quaternion (Baraff, "An Introduction to Physically Based Modeling",
/// SIGGRAPH 1997). Every term is written out: the order of operations fixes the bits of all runs.
Eigen::Matrix3d rotation_of(const Eigen::Quaterniond& q) {
  const double w = q.w(), x = q.x(), y = q.y(), z = q.z();
  const double xx = 2 * x * x, yy = 2 * y * y, zz = 2 * z * z;
  Eigen::Matrix3d R;
  R << 1 - yy - zz, 2 * (x * y - w * z), 2 * (x * z + w * y),  //
      2 * (x * y + w * z), 1 - xx - zz, 2 * (y * z - w * x),   //
      2 * (x * z - w * y), 2 * (y * z + w * x), 1 - xx - yy;
  return R;
}

}  // namespace

void RigidBody::set_orientation(const Eigen::Quaterniond& q_WB) {
  const double w = q_WB.w(), x = q_WB.x(), y = q_WB.y(), z = q_WB.z();
  // Normalising in every step keeps the quaternion's rounding errors from growing.
  const double squared = w * w + x * x + y * y + z * z;
  const double scale = squared > 0 ? 1 / std::sqrt(squared) : 1;
  motion_.q_WB = Eigen::Quaterniond(scale * w, scale * x, scale * y, scale * z);
  R_WB_ = rotation_of(motion_.q_WB);
}

void RigidBody::restore(const BodyMotion& motion) {
  motion_ = motion;
  R_WB_ = rotation_of(motion_.q_WB);
}

void RigidBody::set_mass(double mass_kg, const Eigen::Matrix3d& inertia_B) {
  assert(mass_kg > 0);
  mass_kg_ = mass_kg;
  inertia_B_ = inertia_B.selfadjointView<Eigen::Upper>();
  inverse_inertia_B_ = inertia_B_.inverse();
}

}  // namespace aprsim::physics
