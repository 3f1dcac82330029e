#pragma once

#include <optional>
#include <vector>

#include "world/robot/kinematics/branched_ik.hpp"
#include "world/robot/kinematics/numeric/pose_solver.hpp"

namespace aprsim::robot {

/// Inverse kinematics of any arm, by searches from the seed and from a fixed list of postures. The
/// parameter of redundancy of a seven-axis arm is one of its joints: the one without which the
/// other six move the flange best. Its angle is the elbow angle; the range of a prismatic joint
/// counts as one turn, from -pi to pi.
class NumericIk final : public BranchedIk {
 public:
  explicit NumericIk(const ArmModel& model);

  /// Follows the branch of the seed where the pose is near; else the nearest of all() that are
  /// found.
  [[nodiscard]] Result<JointVector> nearest(const Eigen::Isometry3d& X_BF, const JointVector& seed,
                                            double elbow_rad) const override;
  [[nodiscard]] double elbow_of(const JointVector& q) const override;
  /// Signs of joints 2 and 3, and of the last but one.
  [[nodiscard]] api::Posture posture_of(const JointVector& q) const override;
  [[nodiscard]] Result<double> choose_elbow(const Eigen::Isometry3d& X_BF,
                                            const JointVector& seed) const override;
  [[nodiscard]] Branches branches(const Eigen::Isometry3d& X_BF, const JointVector& seed,
                                  double elbow_rad) const override;

 private:
  [[nodiscard]] PoseResidual solve(const Eigen::Isometry3d& X_BF, double elbow_rad,
                                   bool keep_limits, JointVector& q) const;
  [[nodiscard]] double locked_position(double elbow_rad, double seed) const;
  [[nodiscard]] bool follow(const Eigen::Isometry3d& X_BF, const JointVector& seed,
                            double elbow_rad, JointVector& q) const;
  void add(const JointVector& q, Branches& out) const;
  void search(const Eigen::Isometry3d& X_BF, const JointVector& seed, double elbow_rad,
              Branches& out) const;

  ArmModel model_;
  std::vector<JointVector> starts_;
  std::optional<int> locked_;
  double reach_m_ = 0;  ///< bound of the flange's distance from the first joint
};

}  // namespace aprsim::robot
