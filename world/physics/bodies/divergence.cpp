#include "world/physics/bodies/divergence.hpp"

#include <cmath>

namespace aprsim::physics {
namespace {

// [m/s] of the centre of mass, and of the rim about it. Impacts of parts are tested to 30 m/s; a
// part on end may spin up to several times as fast at its rim.
constexpr double kMaxSpeed = 500, kMaxRimSpeed = 1000;
constexpr double kLeastRadius_m = 1e-3;

/// A comparison with what is not a number is false.
bool is_bounded(const Eigen::Vector3d& v_W, const Eigen::Vector3d& omega_W, double radius_m) {
  return v_W.squaredNorm() <= kMaxSpeed * kMaxSpeed &&
         radius_m * radius_m * omega_W.squaredNorm() <= kMaxRimSpeed * kMaxRimSpeed;
}

}  // namespace

// A sum with what is not a number is none.
bool has_diverged(const FreeBody& body) {
  return !is_bounded(body.v_com_W, body.omega_W, body.radius_m) ||
         !std::isfinite(body.X_WB.matrix().sum());
}

bool has_diverged(const BodyMotion& motion) {
  return !is_bounded(motion.v_W, motion.omega_W, kLeastRadius_m) ||
         !std::isfinite(motion.p_W.sum() + motion.q_WB.coeffs().sum());
}

}  // namespace aprsim::physics
