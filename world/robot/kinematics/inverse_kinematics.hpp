#pragma once

#include <vector>

#include "world/api/values/posture.hpp"
#include "world/robot/model/arm_model.hpp"

namespace aprsim::robot {

/// One joint vector that reaches the pose exactly, within the joint limits unless said otherwise.
struct IkSolution {
  JointVector q;
};

/// Inverse kinematics of an arm: in closed form for the families of arms that have one, else
/// numeric. The same arguments give the same bits. An arm of fewer than six axes reaches the poses
/// that its axes allow; a pose tilted against these by up to 1e-4 rad counts as one of them.
/// Immutable after construction. Thread: any.
class InverseKinematics {
 public:
  virtual ~InverseKinematics() = default;

  /// Every solution within limits, in all branches and with all full turns that the limits allow.
  /// A redundant arm gives those of its elbow angle `elbow_rad` (ignored by other arms). A numeric
  /// solver gives those that it finds from a fixed list of starts. May allocate.
  [[nodiscard]] virtual std::vector<IkSolution> all(const Eigen::Isometry3d& X_BF,
                                                    double elbow_rad) const = 0;

  /// The solution nearest to `seed` (weighted by joint range); a redundant arm keeps `elbow_rad`.
  /// Does not allocate when it succeeds. Errors: kUnreachable, field names the axis or joint, the
  /// message the value, the limit and its unit (out of reach by how much, tilted by how much,
  /// joint n at a of b).
  [[nodiscard]] virtual Result<JointVector> nearest(const Eigen::Isometry3d& X_BF,
                                                    const JointVector& seed,
                                                    double elbow_rad) const = 0;

  /// Elbow angle of a posture; 0 for an arm that is not redundant.
  [[nodiscard]] virtual double elbow_of(const JointVector& q) const = 0;

  /// The branch and elbow angle of a posture.
  [[nodiscard]] virtual api::Posture posture_of(const JointVector& q) const = 0;

  /// Elbow angle with which X_BF is reached nearest to `seed` and away from joint limits: searched
  /// once a command, never in a step. Errors as nearest().
  [[nodiscard]] virtual Result<double> choose_elbow(const Eigen::Isometry3d& X_BF,
                                                    const JointVector& seed) const = 0;
};

}  // namespace aprsim::robot
