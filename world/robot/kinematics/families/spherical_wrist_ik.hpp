#pragma once

#include "world/robot/kinematics/branched_ik.hpp"

namespace aprsim::robot {

/// Lengths of a six-axis arm with axes z y y x y x and a spherical wrist, flange approach along x.
struct SphericalWristGeometry {
  double shoulder_z = 0;  ///< base to axis 2 [m]
  double shoulder_x = 0;  ///< axis 1 to axis 2
  double lateral = 0;     ///< axis 1 to the arm's plane along y
  double upper = 0;       ///< axis 2 to axis 3
  double elbow_z = 0;     ///< axis 3 to axis 4
  double fore_x = 0;      ///< axis 3 to wrist centre along axis 4
  double flange_x = 0;    ///< wrist centre to flange
  JointVector sign;       ///< of each joint axis: +1 along the axis named above, else -1
};

/// Closed form by decoupling of position and orientation at the wrist centre (Pieper 1968). Up to 8
/// branches: facing the target or away from it, elbow up or down, wrist flipped or not.
class SphericalWristIk final : public BranchedIk {
 public:
  SphericalWristIk(const ArmModel& model, SphericalWristGeometry geometry);

  [[nodiscard]] api::Posture posture_of(const JointVector& q) const override;

  [[nodiscard]] Branches branches(const Eigen::Isometry3d& X_BF, const JointVector& seed,
                                  double elbow_rad) const override;

 private:
  SphericalWristGeometry geometry_;
  double fore_ = 0;        ///< axis 3 to wrist centre
  double fore_angle_ = 0;  ///< of that line above axis 4
};

}  // namespace aprsim::robot
