#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "world/api/commands/trajectory_command.hpp"
#include "world/api/values/joint_count.hpp"
#include "world/robot/model/arm_model.hpp"

namespace aprsim::robot {

/// The tolerances of a trajectory that is followed as a whole. A copyable value. Thread: sim.
struct StreamGoal {
  bool active = false;
  std::array<api::JointTolerance, api::kMaxJoints> path{}, goal{};  ///< 0 = any
  std::int64_t steps_left = 0;  ///< for reaching the goal after the end; -1 = without a limit
  std::int64_t delay = 0;       ///< steps until the start

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [active, path, goal, steps_left, delay] = self;
    io(active, path, goal, steps_left, delay);
  }
  template <typename In>
  void require_valid(In& in) const {
    in.require(steps_left >= -1 && delay >= 0, "a trajectory with a negative time");
  }
};

/// The desired and the actual motion of an arm.
struct TrackingState {
  const JointVector &q_desired, &qd_desired, &q_actual, &qd_actual;
};

/// The first difference that is beyond its tolerance, in words; empty = none.
[[nodiscard]] std::string beyond_tolerance(
    const std::array<api::JointTolerance, api::kMaxJoints>& tolerance, const ArmModel& model,
    const TrackingState& state);

}  // namespace aprsim::robot
