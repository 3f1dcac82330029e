#pragma once

#include "world/robot/kinematics/branched_ik.hpp"

namespace aprsim::robot {

/// Lengths of a seven-axis arm with axes z y z y z y z whose first three axes meet in the shoulder
/// and whose axes 5 and 6 meet in the wrist. The base is at the shoulder.
struct OffsetElbowGeometry {
  double elbow_x = 0;  ///< axis 3 to axis 4 [m]
  double upper = 0;    ///< shoulder to axis 4 along axis 3
  double fore_x = 0;   ///< axis 4 to axis 5
  double fore = 0;     ///< axis 4 to the wrist along axis 5
  double wrist_x = 0;  ///< wrist to axis 7
};

/// Closed form of arms like the Franka Emika Panda with the angle of the last joint as the
/// parameter of redundancy (He & Liu 2021, "Analytical inverse kinematics for Franka Emika Panda"):
/// the elbow angle is that of joint 7. Up to 8 branches per angle.
class OffsetElbowIk final : public BranchedIk {
 public:
  OffsetElbowIk(const ArmModel& model, const OffsetElbowGeometry& geometry);

  [[nodiscard]] double elbow_of(const JointVector& q) const override;
  /// Signs of joint 2, of the elbow's bend and of the wrist's side.
  [[nodiscard]] api::Posture posture_of(const JointVector& q) const override;

  [[nodiscard]] Branches branches(const Eigen::Isometry3d& X_BF, const JointVector& seed,
                                  double elbow_rad) const override;

 private:
  [[nodiscard]] Eigen::Vector3d wrist_in_fore(double t4) const;
  void add_wrists(const Eigen::Matrix3d& R_6, const Eigen::Vector3d& wrist, double t4,
                  const JointVector& seed, double elbow_rad, Branches& out) const;

  OffsetElbowGeometry geometry_;
  double upper_ = 0, fore_ = 0;              ///< shoulder to axis 4, axis 4 to wrist
  double upper_angle_ = 0, fore_angle_ = 0;  ///< of these lines, from z towards x
};

}  // namespace aprsim::robot
