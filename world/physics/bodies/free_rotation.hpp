#pragma once

#include <Eigen/Geometry>

namespace aprsim::physics {

/// The rotation vector over `step_s` of a body that no torque acts on, divided by the step: its
/// mean angular velocity [rad/s], in world axes. `inertia_B`: about the centre of mass, in body
/// axes [kg m^2]; `q_WB`: attitude at the start; `omega_W`: angular velocity there [rad/s].
///
/// Implicit midpoint rule for the angular momentum in body axes, with a Cayley rotation for the
/// attitude (Austin, Krishnaprasad & Wang, "Almost Poisson integration of rigid body systems",
/// 1993; Simo & Wong 1991). Energy and angular momentum are kept to rounding for any step.
/// Composed by Yoshida's triple jump (1990) to fourth order in the attitude. The motion of bodies
/// with z as axis of symmetry is exact, in closed form. No allocation.
[[nodiscard]] Eigen::Vector3d mean_free_omega(const Eigen::Matrix3d& inertia_B,
                                              const Eigen::Quaterniond& q_WB,
                                              const Eigen::Vector3d& omega_W, double step_s);

}  // namespace aprsim::physics
