#include "world/robot/servo/contact_law.hpp"

#include <algorithm>
#include <cmath>

namespace aprsim::robot {
namespace {

constexpr double kDampingRatio = 0.7;      ///< of sqrt(k m)
constexpr double kDampingPerStep = 0.2;    ///< of m / dt: momentum damped per step
constexpr double kStiffnessPerStep = 0.3;  ///< of m / dt^2
/// Mass of immovable partners (mobility 0), for the damping.
constexpr double kHeaviest = 1e3;

double effective_mass(double mobility_1_kg) {
  return mobility_1_kg > 1 / kHeaviest ? 1 / mobility_1_kg : kHeaviest;
}

}  // namespace

double normal_force(const ContactLaw& law, double depth_m, double closing_speed_m_s,
                    double mobility_1_kg, double step_s, int points) {
  if (depth_m <= 0) return 0;
  // Stiffness and damping within the stability of a force that lags by one step.
  const double m = effective_mass(mobility_1_kg);
  const double k = std::min(law.stiffness_n_m, kStiffnessPerStep * m / (step_s * step_s));
  // Damping ratio zeta: d = 2 zeta sqrt(k m) with zeta = 0.35.
  const double d = std::min(kDampingRatio * std::sqrt(k * m), kDampingPerStep * m / step_s);
  return std::max(0.0, k * depth_m + d * closing_speed_m_s) / points;
}

Eigen::Vector3d friction_force(const ContactLaw& law, double normal_force_n,
                               const Eigen::Vector3d& slip_W, double mobility_1_kg, double step_s,
                               int points) {
  const double speed = slip_W.norm();
  if (speed == 0 || normal_force_n <= 0) return Eigen::Vector3d::Zero();
  // Coulomb, regularised: viscous where that is less.
  const double viscous = kDampingPerStep * effective_mass(mobility_1_kg) * speed / step_s / points;
  return -slip_W / speed * std::min(law.friction * normal_force_n, viscous);
}

}  // namespace aprsim::robot
