#pragma once

#include "world/physics/bodies/contact_constraint.hpp"

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

/// Surroundings of a contact in a step.
struct ContactSetting {
  bool arm_link = false;  ///< it is with an arm's link
  Eigen::Vector3d belt_axis_W = Eigen::Vector3d::UnitX();
  double belt_speed_m_s = 0;
  double step_s = 1e-3;
  double flight_step_s = 1e-3;  ///< of the steps in which a body flies to and from the contact
  /// Along the normal, of a relative to b, before the step; < 0: they approach.
  double normal_speed_m_s = 0;
  double normal_accel_m_s2 = 0;  ///< of a relative to b without the contact
};

[[nodiscard]] ContactResponse contact_response(const ContactConstraint& constraint,
                                               const ContactSetting& setting);

}  // namespace aprsim::physics
