#pragma once

#include <array>
#include <limits>

#include "world/api/motion_command.hpp"
#include "world/api/robot_snapshot.hpp"
#include "world/robot/model/arm_model.hpp"

namespace aprsim::robot {

/// How near its target an arm that is pushed aside must be before its motion counts as done. What
/// is absent, or infinite, does not matter.
struct ArrivalTolerance {
  ArrivalTolerance() { joint_rad.fill(std::numeric_limits<double>::infinity()); }

  api::PoseTolerance pose;
  std::array<double, api::kMaxJoints> joint_rad{};
};

/// Whether the arm at `q` is near enough to `target`. Poses are those of the tool in R. Tolerances
/// below what the servo can tell (1 um, 1 urad) count as that much.
[[nodiscard]] bool has_arrived(const ArrivalTolerance& tolerance, const ArmModel& model,
                               const Eigen::Isometry3d& X_RB, const Eigen::Isometry3d& X_FT,
                               const JointVector& q, const JointVector& target);

}  // namespace aprsim::robot
