#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "world/robot/controller/arrival.hpp"
#include "world/robot/controller/command_progress.hpp"
#include "world/robot/controller/motion_generator.hpp"
#include "world/robot/controller/motion_stream.hpp"
#include "world/robot/controller/plan_queue.hpp"
#include "world/robot/controller/tool_change_sequence.hpp"
#include "world/robot/trajectory/limits/tool_limits.hpp"

namespace aprsim::robot {

/// The state of a controller while it runs: a copy that is restored later continues bit for bit.
struct ControllerState {
  ControllerState(const ToolLimits& maximum, const JointVector& q_home, int tool)
      : tool_limits(maximum), motion(q_home), changer(tool) {}

  ToolLimitSettings tool_limits;
  MotionGenerator motion;
  PlanQueue plans;
  ToolChangeSequence changer;
  CommandProgress command;
  MotionStream stream;
  std::optional<Pose> X_RG;            ///< goal pose of the tool by the latest move
  ArrivalTolerance arrival_tolerance;  ///< of the running motion
  bool protection = false;             ///< after a protective stop, until InitRobot
  double gripper_setting = 1;
  std::int64_t steps_left = 0;   ///< of a dwell, or until a gripper's deadline
  bool gripper_applied = false;  ///< a step has passed since the command
  api::PlanningMode planning = api::PlanningMode::kDirect;
  std::uint64_t motions_begun = 0;
  /// Path of the latest motion that was checked against its surroundings, in R [m].
  std::shared_ptr<const std::vector<Eigen::Vector3d>> path{};

  /// Memory besides what copies share, approximately.
  [[nodiscard]] std::size_t bytes() const {
    return sizeof *this + bytes_of(changer.deferred()) + plans.bytes() + motion.bytes() +
           stream.bytes();
  }
  /// Adds what copies share: the plans of motions.
  void list(SharedParts& parts) const {
    motion.list(parts);
    plans.list(parts);
    stream.list(parts);
    if (path) parts[path.get()] = sizeof *path + bytes_of(*path);
  }

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [tool_limits, motion, plans, changer, command, stream, X_RG, arrival_tolerance,
           protection, gripper_setting, steps_left, gripper_applied, planning, motions_begun,
           path] = self;
    io(tool_limits, motion, plans, changer, command, stream, X_RG, arrival_tolerance, protection,
       gripper_setting, steps_left, gripper_applied, planning, motions_begun, path);
  }
};

}  // namespace aprsim::robot
