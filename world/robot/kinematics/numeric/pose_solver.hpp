#pragma once

#include <optional>

#include "world/robot/model/arm_model.hpp"

namespace aprsim::robot {

/// A pose to be reached by an arm's joints, or by all but one of them.
struct PoseProblem {
  const ArmModel& model;
  Eigen::Isometry3d X_BF = Eigen::Isometry3d::Identity();
  std::optional<int> locked;  ///< joint that stays where it is
  bool keep_limits = true;
};

/// Distance of the flange from the pose at the end of a search.
struct PoseResidual {
  bool reached = false;  ///< within the tolerances below
  bool exact = false;    ///< within 1e-9 m and rad; of fewer than six axes 1e-8
  double position_m = 0, rotation_rad = 0;
};

/// Moves `q` to a posture that has the flange at the pose, by Levenberg-Marquardt steps (Sugihara
/// 2011, "Solvability-unconcerned inverse kinematics by the Levenberg-Marquardt method") in at most
/// 60 steps. Reached: within 1e-9 m and rad; an arm of fewer than six axes within 1e-7 m and the
/// tilt that counts as none. The same arguments give the same bits. Does not allocate. Thread: any.
[[nodiscard]] PoseResidual solve_pose(const PoseProblem& problem, JointVector& q);

}  // namespace aprsim::robot
