#pragma once

#include <memory>

#include "world/robot/kinematics/branched_ik.hpp"

namespace aprsim::robot {

/// Between an arm and the frames and zero angles of its family.
struct Placement {
  Eigen::Isometry3d X_BA = Eigen::Isometry3d::Identity();  ///< the family's base frame
  Eigen::Isometry3d X_EF = Eigen::Isometry3d::Identity();  ///< flange in the family's last frame
  JointVector sign;                                        ///< t = sign q + offset, t the family's
  JointVector offset;

  [[nodiscard]] JointVector family(const JointVector& q) const {
    return q.cwiseProduct(sign) + offset;
  }
};

/// An arm of a family whose description has other frames, senses of rotation or zero angles: every
/// arm is rewritten into its axes' lines, and these into those of the family.
class PlacedIk final : public BranchedIk {
 public:
  /// `family` solves the arm in the family's own angles; its limits do not matter.
  PlacedIk(const ArmModel& model, Placement placement, std::unique_ptr<const BranchedIk> family);

  [[nodiscard]] double elbow_of(const JointVector& q) const override;
  [[nodiscard]] api::Posture posture_of(const JointVector& q) const override;

  [[nodiscard]] Branches branches(const Eigen::Isometry3d& X_BF, const JointVector& seed,
                                  double elbow_rad) const override;

 private:
  Placement placement_;
  Eigen::Isometry3d X_AB_, X_FE_;
  std::unique_ptr<const BranchedIk> family_;
};

}  // namespace aprsim::robot
