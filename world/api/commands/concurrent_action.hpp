#pragma once

#include <variant>

#include "world/api/commands/robot_command.hpp"

namespace aprsim::api {

/// Whether a robot executes the action beside a running motion, which goes on to its target with
/// its guards: settings, the gripper, a dwell. NIST's servers do so, too (FanucCRCLMain
/// handleSetEndEffector and handleDwell, MotomanCRCLServer setEndEffector, SimServerInner
/// readCommand).
[[nodiscard]] inline bool leaves_motion(const RobotAction& action) {
  return is_setting(action) || std::holds_alternative<SetGripper>(action) ||
         std::holds_alternative<Dwell>(action);
}

}  // namespace aprsim::api
