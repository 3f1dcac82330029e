#pragma once

#include <array>

#include "world/robot/kinematics/branched_ik.hpp"

namespace aprsim::robot {

/// Lengths of a SCARA: three axes of rotation and one of sliding, all along z. The base is on the
/// first axis of rotation, the flange on the third.
struct ScaraGeometry {
  double upper = 0;            ///< first to second axis [m]
  double fore = 0;             ///< second to third axis
  std::array<int, 3> turning;  ///< the joints that turn, 0-based
  int sliding = 3;             ///< the joint that slides
};

/// Closed form in the plane: two branches, elbow left or right.
class ScaraIk final : public BranchedIk {
 public:
  ScaraIk(const ArmModel& model, const ScaraGeometry& geometry);

  [[nodiscard]] api::Posture posture_of(const JointVector& q) const override;

  [[nodiscard]] Branches branches(const Eigen::Isometry3d& X_BF, const JointVector& seed,
                                  double elbow_rad) const override;

 private:
  ScaraGeometry geometry_;
};

}  // namespace aprsim::robot
