#pragma once

#include <cstddef>
#include <variant>
#include <vector>

#include "world/api/commands/motion_command.hpp"
#include "world/api/values/guard.hpp"
#include "world/api/values/planning_mode.hpp"
#include "world/base/time.hpp"

/// The commands to one robot.
namespace aprsim::api {

/// Aborts any motion without leaving the present position, clears a held error, makes ready.
struct InitRobot {};
/// Ends a program: stops motion; the robot holds its position and stays initialized.
struct EndProgram {};

enum class StopKind {
  kImmediate,  ///< as fast as the joints can, the path may be left; then drives off, brakes on
  kFast,       ///< on the path at maximal deceleration; drives off and brakes on 1 s later
  kNormal,     ///< braking ramp on the path at the set deceleration; the drives stay on
};
/// For checks of states (world/archive).
[[nodiscard]] constexpr StopKind last_of(StopKind) { return StopKind::kNormal; }
struct StopMotion {
  StopKind kind = StopKind::kNormal;
};

/// 0 = closed, 1 = open. A gripper that is not proportional opens above 0.5.
struct SetGripper {
  double setting = 0;
};

/// Opens the tool changer: the gripper stays where it is and the tool frame becomes the flange's.
/// Or closes it: a gripper that sits at the flange is taken and the tool frame is its again.
struct SetToolChanger {
  bool open = false;
};

/// Scales the speed of running and later motion, smoothly; 0 holds a motion where it is.
struct SetOverride {
  double fraction = 1;  ///< 0..1
};

/// Sets the supply pressure of a pneumatic gripper by the force that each finger then presses with.
struct SetGripperForce {
  double force_n = 0;  ///< above 0, at most GripperDescription::force_n
};

/// Holds position for a span of simulated time.
struct Dwell {
  SimTime duration{};
};

enum class MotionLimit { kTransSpeed, kTransAccel, kRotSpeed, kRotAccel };
/// For checks of states (world/archive).
[[nodiscard]] constexpr MotionLimit last_of(MotionLimit) { return MotionLimit::kRotAccel; }
/// Sets one of the limits that later moves obey. Absolute [m/s, m/s^2, rad/s, rad/s^2], or
/// relative as a fraction 0..1 of the robot's maximum.
struct SetMotionLimit {
  MotionLimit which = MotionLimit::kTransSpeed;
  bool relative = false;
  double value = 0;
};

/// Sets how later moves regard what stands around the robot.
struct SetPlanning {
  PlanningMode mode = PlanningMode::kDirect;
};

using RobotAction = std::variant<InitRobot, EndProgram, StopMotion, MoveTo, MoveThroughTo,
                                 MoveScrew, MoveJoints, SetGripper, SetGripperForce, SetToolChanger,
                                 SetOverride, Dwell, SetMotionLimit, SetPlanning>;

/// Which of RobotAction's commands, in its order.
enum class ActionKind {
  kNone,
  kInit,
  kEnd,
  kStop,
  kMoveTo,
  kMoveThroughTo,
  kMoveScrew,
  kMoveJoints,
  kGripper,
  kGripperForce,
  kToolChanger,
  kOverride,
  kDwell,
  kMotionLimit,
  kPlanning,
};
/// For checks of states (world/archive).
[[nodiscard]] constexpr ActionKind last_of(ActionKind) { return ActionKind::kPlanning; }
static_assert(std::variant_size_v<RobotAction> == static_cast<std::size_t>(ActionKind::kPlanning));
[[nodiscard]] inline ActionKind kind_of(const RobotAction& action) {
  return static_cast<ActionKind>(action.index() + 1);
}

/// Whether the action only changes a setting: it takes effect at once, leaves the running motion
/// and its guards alone and has no guards of its own.
[[nodiscard]] inline bool is_setting(const RobotAction& action) {
  return std::holds_alternative<SetMotionLimit>(action) ||
         std::holds_alternative<SetOverride>(action) ||
         std::holds_alternative<SetGripperForce>(action) ||
         std::holds_alternative<SetPlanning>(action);
}

/// Whether the action is a motion that is planned.
[[nodiscard]] inline bool is_move(const RobotAction& action) {
  return std::holds_alternative<MoveTo>(action) || std::holds_alternative<MoveThroughTo>(action) ||
         std::holds_alternative<MoveScrew>(action) || std::holds_alternative<MoveJoints>(action);
}

struct RobotCommand {
  int robot = 0;  ///< index into CellDescription::robots
  RobotAction action;
  /// End the action; at most kMaxGuards. A setting has none.
  std::vector<Guard> guards{};
};

}  // namespace aprsim::api
