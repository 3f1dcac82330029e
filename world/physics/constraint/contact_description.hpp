#pragma once

#include <Eigen/Core>

namespace aprsim::physics {

/// Warm start of an impulse: that of the last step, or extrapolated linearly by its change.
template <typename Value>
struct ImpulseGuess {
  Value last, change;
};

/// A contact as it is added to a ContactProblem. SI, world axes.
struct ContactDescription {
  int a = -1, b = -1;  ///< bodies, -1 = fixed to the world
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  Eigen::Vector3d n = Eigen::Vector3d::UnitZ();  ///< from b into a
  double friction = 0;                           ///< Coulomb's coefficient
  double spinning_m = 0;  ///< limit of the friction torque about n, per normal force
  double rolling_m = 0;   ///< limit of the torque across n, per normal force
  /// Target of the velocity of a relative to b. Along n it is a lower bound (a gap may close, or
  /// penetration is corrected), across n the velocity of a moving surface.
  Eigen::Vector3d target_v = Eigen::Vector3d::Zero();
  double compliance_m_s_ns = 0;           ///< normal velocity per normal impulse
  double friction_compliance_m_s_ns = 0;  ///< slip velocity per friction impulse
  ImpulseGuess<Eigen::Vector3d> impulse_ns = {Eigen::Vector3d::Zero(),
                                              Eigen::Vector3d::Zero()};  ///< on a
  /// Friction torque on a, times the step.
  ImpulseGuess<Eigen::Vector3d> torsional_impulse_nms = {Eigen::Vector3d::Zero(),
                                                         Eigen::Vector3d::Zero()};
};

}  // namespace aprsim::physics
