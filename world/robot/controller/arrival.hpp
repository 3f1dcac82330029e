#pragma once

#include <array>
#include <limits>

#include "world/api/commands/motion_command.hpp"
#include "world/api/snapshot/robot_snapshot.hpp"
#include "world/robot/model/arm_model.hpp"
#include "world/robot/planning/plan_job.hpp"

namespace aprsim::robot {

/// Tolerance of the target within which a motion is done, for an arm that contact pushes aside.
/// Absent or infinite tolerances are ignored.
struct ArrivalTolerance {
  ArrivalTolerance() { joint_rad.fill(std::numeric_limits<double>::infinity()); }

  api::PoseTolerance pose;
  std::array<double, api::kMaxJoints> joint_rad{};

  static constexpr bool kUnbounded = true;

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [pose, joint_rad] = self;
    io(pose, joint_rad);
  }
};

/// The tolerance that the command sets at its end. A joint in torque mode has none.
[[nodiscard]] ArrivalTolerance arrival_tolerance_of(const PlannedMove& move);

/// Whether the arm at `q` is within tolerance of `target`. Poses are those of the tool in R.
/// Tolerances below the servo's resolution (1 um, 1 urad) count as that.
[[nodiscard]] bool has_arrived(const ArrivalTolerance& tolerance, const ArmModel& model,
                               const Eigen::Isometry3d& X_RB, const Eigen::Isometry3d& X_FT,
                               const JointVector& q, const JointVector& target);

}  // namespace aprsim::robot
