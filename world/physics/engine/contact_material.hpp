#pragma once

#include "world/physics/bodies/contact_constraint.hpp"
#include "world/physics/engine/contact_setting.hpp"

namespace aprsim::physics {

/// How the two surfaces of a contact act on each other in a step; friction is the constraint's own.
struct ContactResponse {
  double compliance_m_s_n = 0;           ///< normal velocity per normal force
  double friction_compliance_m_s_n = 0;  ///< slip velocity per friction force
  /// Velocity of a relative to b that is aimed at: along the normal the least, by which a gap may
  /// close and penetration is corrected; across it that of a belt.
  Eigen::Vector3d target_v_W = Eigen::Vector3d::Zero();
  double rebound_m_s = 0;  ///< speed along the normal that an impact gives back, beyond the target
  double unanswered_m2_s2 = 0;  ///< energy per mass of an impact that the next step answers
};

/// Penetration slop: resting bodies keep this depth, and with it their contacts. Trays are shoved,
/// and need more. Squeezed parts keep their contacts without a slop, and could stick off centre
/// within one.
[[nodiscard]] double penetration_slop_m(SurfacePair pair);

[[nodiscard]] ContactResponse contact_response(const ContactConstraint& constraint,
                                               const ContactSetting& setting);

}  // namespace aprsim::physics
