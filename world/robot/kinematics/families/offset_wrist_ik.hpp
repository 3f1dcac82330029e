#pragma once

#include "world/robot/kinematics/branched_ik.hpp"

namespace aprsim::robot {

/// Lengths of a six-axis arm with axes z y y y z y, whose axes 5 and 6 meet in the wrist centre.
/// The flange is at the wrist centre.
struct OffsetWristGeometry {
  double shoulder_x = 0;  ///< axis 1 to axis 2 [m]
  double lateral = 0;     ///< axis 1 to the wrist centre along y
  double upper = 0;       ///< axis 2 to axis 3
  double fore = 0;        ///< axis 3 to axis 4
  double wrist_z = 0;     ///< axis 4 to the wrist centre along axis 5
};

/// Closed form of arms whose axes 2, 3 and 4 are parallel (Hawkins 2013, "Analytic inverse
/// kinematics for the Universal Robots UR-5/UR-10 arms"). Up to 8 branches: facing the target or
/// away from it, wrist turned in or out, elbow up or down.
class OffsetWristIk final : public BranchedIk {
 public:
  OffsetWristIk(const ArmModel& model, const OffsetWristGeometry& geometry);

  [[nodiscard]] api::Posture posture_of(const JointVector& q) const override;

  [[nodiscard]] Branches branches(const Eigen::Isometry3d& X_BF, const JointVector& seed,
                                  double elbow_rad) const override;

 private:
  void add_elbows(double t1, const Eigen::Matrix3d& R, const Eigen::Vector3d& wrist,
                  const JointVector& seed, Branches& out) const;

  OffsetWristGeometry geometry_;
};

}  // namespace aprsim::robot
