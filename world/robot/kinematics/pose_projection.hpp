#pragma once

#include "world/robot/model/arm_model.hpp"

namespace aprsim::robot {

/// Moves `q` to a posture nearby that has the flange at X_BF, exact to rounding, by Newton steps of
/// the least joint motion (Siciliano et al. 2009, sec. 3.7). A smooth function of X_BF and `q`,
/// also where single axes are aligned, as long as the arm as a whole is not singular; false where
/// it is, or where `q` is too far away. Limits do not matter. Does not allocate. Thread: any.
[[nodiscard]] bool project_to_pose(const ArmModel& model, const Eigen::Isometry3d& X_BF,
                                   JointVector& q);

/// How far the arm as a whole is from a singular posture: the smallest pivot of J J^T, with lengths
/// in units of 0.4 m; 0 where a direction of motion is lost. Does not allocate.
[[nodiscard]] double dexterity(const ArmModel& model, const JointVector& q);

}  // namespace aprsim::robot
