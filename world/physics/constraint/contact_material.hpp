#pragma once

#include <ode/ode.h>

#include "world/physics/bodies/contact_constraint.hpp"
#include "world/physics/bodies/static_shapes.hpp"

namespace aprsim::physics {

/// ODE's description of a touch: friction, softness, the belt's motion. `slide_W` is the direction
/// across the normal in which friction is to act, zero = any: along its first axis ODE's pyramid is
/// the true cone.
[[nodiscard]] dContact ode_contact(const ContactConstraint& touch, bool soft,
                                   const Eigen::Vector3d& belt_axis_W, double belt_speed_m_s,
                                   const Eigen::Vector3d& slide_W = Eigen::Vector3d::Zero());

}  // namespace aprsim::physics
