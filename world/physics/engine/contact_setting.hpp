#pragma once

#include <Eigen/Core>

namespace aprsim::physics {

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

}  // namespace aprsim::physics
