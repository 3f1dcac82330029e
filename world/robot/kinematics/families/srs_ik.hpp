#pragma once

#include "world/robot/kinematics/branched_ik.hpp"

namespace aprsim::robot {

/// Lengths of a seven-axis arm with axes z y z y z y z, spherical shoulder and wrist, flange
/// approach along z.
struct SrsGeometry {
  double shoulder_z = 0;  ///< base to shoulder centre [m]
  double upper = 0;       ///< shoulder centre to elbow
  double fore = 0;        ///< elbow to wrist centre
  double flange_z = 0;    ///< wrist centre to flange
  JointVector sign;       ///< of each joint axis: +1 along the axis named above, else -1
};

/// Closed form with the elbow angle as the parameter of redundancy (the arm angle of
/// Kreutz-Delgado, Long & Seraji 1992; Shimizu et al. 2008). Up to 8 branches per elbow angle. The
/// elbow angle turns the elbow about the line from shoulder to wrist; at 0 it is straight above
/// that line. It is undefined only when the wrist centre is on axis 1.
class SrsIk final : public BranchedIk {
 public:
  SrsIk(const ArmModel& model, SrsGeometry geometry);

  [[nodiscard]] double elbow_of(const JointVector& q) const override;
  [[nodiscard]] api::Posture posture_of(const JointVector& q) const override;

  [[nodiscard]] Branches branches(const Eigen::Isometry3d& X_BF, const JointVector& seed,
                                  double elbow_rad) const override;

 private:
  SrsGeometry geometry_;
};

}  // namespace aprsim::robot
