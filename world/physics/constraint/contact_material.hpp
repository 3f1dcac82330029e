#pragma once

#include "world/physics/bodies/contact_constraint.hpp"

namespace aprsim::physics {

/// How the two surfaces of a contact act on each other in a step; friction is the constraint's own.
struct ContactResponse {
  double cfm = 0;  ///< softness: normal velocity per normal force [m/s per N]
  /// Velocity of a relative to b that is aimed at: along the normal the least, by which a gap may
  /// close and penetration is corrected; across it that of a belt.
  Eigen::Vector3d target_v_W = Eigen::Vector3d::Zero();
};

/// `arm_link`: the contact is with an arm's link.
[[nodiscard]] ContactResponse contact_response(const ContactConstraint& constraint, bool arm_link,
                                               const Eigen::Vector3d& belt_axis_W,
                                               double belt_speed_m_s, double step_s);

}  // namespace aprsim::physics
