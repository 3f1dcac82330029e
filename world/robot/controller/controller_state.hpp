#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "world/api/commands/motion_command.hpp"
#include "world/api/commands/robot_command.hpp"
#include "world/api/snapshot/robot_snapshot.hpp"
#include "world/robot/controller/retreat_trail.hpp"
#include "world/robot/controller/torque_mode.hpp"
#include "world/robot/model/arm_model.hpp"
#include "world/robot/planning/plan_job.hpp"
#include "world/robot/servo/drive_power.hpp"

namespace aprsim::robot {

/// Largest deviation from its target with which the motion of an arm that is pushed aside counts as
/// done. An absent or infinite tolerance does not matter.
struct ArrivalTolerance {
  ArrivalTolerance() { joint_rad.fill(std::numeric_limits<double>::infinity()); }

  api::PoseTolerance pose;
  std::array<double, api::kMaxJoints> joint_rad{};

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [pose, joint_rad] = self;
    io(pose, joint_rad);
  }
};

/// What completes the running command.
enum class Task { kNone, kRest, kGripper, kDwell, kToolChanger };

/// What the tool changer does.
enum class Changer {
  kIdle,
  kWaits,  ///< for the arm to come to rest
  kWorks,  ///< its valve is switched, the lock on its way
};

/// A command that is done after the tool changer's.
struct HeldCommand {
  api::Ticket ticket = 0;
  api::RobotAction action;

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [ticket, action] = self;
    io(ticket, action);
  }
};

/// All that changes while a controller runs: a copy of it, put back later, continues bit for bit.
struct ControllerState {
  ControllerState(const ToolLimits& maximum, const JointVector& q_home)
      : tool_limits(maximum), runner(q_home), joint_targets(q_home) {}

  ToolLimitSettings tool_limits;
  MotionRunner runner;
  /// The move whose motion begins in `planning_steps`; null = none. Shared by copies, which read
  /// its request only.
  std::shared_ptr<PlanJob> planning;
  int planning_steps = 0;
  std::optional<MoveRequest> waiting;  ///< to be planned next: the latest that came meanwhile
  JointVector joint_targets;
  bool to_joint_targets = false;  ///< the running motion goes to joint_targets
  TorqueMode torque_mode;
  bool torque_mode_pending = false;  ///< until the other joints are at rest
  RetreatTrail retreat_trail;
  DrivePower drive_power;
  double override_fraction = 1;
  double speed_share = 1;  ///< of the speed that the override leaves

  api::ActionStatus status;
  std::optional<Pose> X_RG;  ///< goal pose of the tool by the latest move
  Task task = Task::kNone;
  ArrivalTolerance arrival_tolerance;  ///< of the running motion
  std::string held_error;
  std::string note;  ///< description of the running command once it is done
  bool initialized = false, protection = false;
  bool retreating = false;  ///< the running motion is the retreat of a protective stop
  int tool = 0;             ///< on the flange; -1 = none
  Changer changer = Changer::kIdle;
  bool changer_open = false;
  std::int64_t changer_steps = 0;  ///< until the lock has got there
  std::vector<HeldCommand> held;   ///< in their order, for when the changer is done
  double gripper_setting = 1;
  std::int64_t steps_left = 0;   ///< of a dwell, or until a gripper's deadline
  bool gripper_applied = false;  ///< a step has passed since the command

  /// Of memory, besides what copies share; approximately.
  [[nodiscard]] std::size_t bytes() const {
    return sizeof *this + bytes_of(held) + (waiting ? waiting->bytes() : 0) +
           (planning ? sizeof *planning + planning->request().request.bytes() : 0);
  }
  /// Adds what copies share: the plans of motions.
  void list(SharedParts& parts) const {
    runner.list(parts);
    if (planning) planning->request().runner.list(parts);
  }

  /// See world/archive/archive.hpp. Of what is being planned the request.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [tool_limits, runner, planning, planning_steps, waiting, joint_targets, to_joint_targets,
           torque_mode, torque_mode_pending, retreat_trail, drive_power, override_fraction,
           speed_share, status, X_RG, task, arrival_tolerance, held_error, note, initialized,
           protection, retreating, tool, changer, changer_open, changer_steps, held,
           gripper_setting, steps_left, gripper_applied] = self;
    io(tool_limits, runner, planning, planning_steps, waiting, joint_targets, to_joint_targets,
       torque_mode, torque_mode_pending, retreat_trail, drive_power, override_fraction, speed_share,
       status, X_RG, task, arrival_tolerance, held_error, note, initialized, protection, retreating,
       tool, changer, changer_open, changer_steps, held, gripper_setting, steps_left,
       gripper_applied);
  }
};

}  // namespace aprsim::robot
