#pragma once

#include <Eigen/Core>

/// Contact of an arm with fixed bodies or another arm: a penalty law (linear spring and damper with
/// Coulomb friction), because the physics engine computes no force between kinematic bodies. Its
/// force becomes joint torques by J^T in the next step. Pure functions; no call allocates.
namespace aprsim::robot {

struct ContactLaw {
  double stiffness_n_m = 1e5;
  double friction = 0.5;  ///< Coulomb coefficient
};

/// Force [N] >= 0 that pushes the partners apart: max(0, k depth + d closing speed), with
/// d = min(0.7 sqrt(k m), 0.2 m / dt), m = 1 / mobility. `mobility_1_kg`: n^T J_v H^-1 J_v^T n of
/// the contact point along the contact's normal, 0 = immovable, of two arms the sum.
/// `depth_m` <= 0: no contact, no force. `points`: how many contact points share this contact's
/// stiffness. Where the effective mass is too small for the step the contact is softened, so that
/// the lagged force stays stable (k dt^2 + 2 d dt < m, summed over the points).
[[nodiscard]] double normal_force(const ContactLaw& law, double depth_m, double closing_speed_m_s,
                                  double mobility_1_kg, double step_s, int points = 1);

/// Coulomb friction on the body that slides with `slip_W` [m/s] over its partner: against the slip,
/// of size mu f_n, less where that would turn the slip round within a few steps. `mobility_1_kg`
/// is that along the slip.
[[nodiscard]] Eigen::Vector3d friction_force(const ContactLaw& law, double normal_force_n,
                                             const Eigen::Vector3d& slip_W, double mobility_1_kg,
                                             double step_s, int points = 1);

}  // namespace aprsim::robot
