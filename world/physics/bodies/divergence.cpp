#include "world/physics/bodies/divergence.hpp"

namespace aprsim::physics {
namespace {

// [m/s] of the centre of mass, and of the rim about it. Impacts of parts are tested to 30 m/s; a
// part on end may spin up to several times as fast at its rim.
constexpr double kMaxSpeed = 500, kMaxRimSpeed = 1000;

}  // namespace

bool has_diverged(const BodyMotion& motion, double radius_m) {
  // A comparison with what is not a number is false.
  const bool bounded =
      motion.v_W.norm() <= kMaxSpeed && radius_m * motion.omega_W.norm() <= kMaxRimSpeed;
  return !bounded || !motion.p_W.allFinite() || !motion.q_WB.coeffs().allFinite();
}

}  // namespace aprsim::physics
