#pragma once

#include <ode/ode.h>

#include "world/physics/bodies/contact_constraint.hpp"

namespace aprsim::physics {

/// How the two surfaces of a contact act on each other in a step: softness and motion. Both solvers
/// read it; friction is the constraint's own.
struct ContactResponse {
  double depth_m = 0;       ///< penetration that is corrected, >= 0
  double erp = 0;           ///< share of it that a step corrects
  double cfm = 0;           ///< softness: normal velocity per normal force [m/s per N]
  double approach_m_s = 0;  ///< <= 0: normal speed at which the bodies may sink into the slop
  bool directed = false;    ///< friction's first axis is given
  bool belt = false;        ///< the second surface moves along both axes of friction
  Eigen::Vector3d axis_W = Eigen::Vector3d::Zero();  ///< first axis of friction, unit length
  double belt_m_s = 0, belt_across_m_s = 0;  ///< velocity of the second surface along both axes
};

/// `slide_W` is the direction across the normal in which friction is to act, zero = any: along its
/// first axis a friction pyramid is the true cone. `arm_link`: the contact is with an arm's link.
[[nodiscard]] ContactResponse contact_response(
    const ContactConstraint& constraint, bool arm_link, const Eigen::Vector3d& belt_axis_W,
    double belt_speed_m_s, const Eigen::Vector3d& slide_W = Eigen::Vector3d::Zero());

/// The same in ODE's terms, friction and contact point included.
[[nodiscard]] dContact ode_contact(const ContactConstraint& constraint,
                                   const ContactResponse& response);

}  // namespace aprsim::physics
