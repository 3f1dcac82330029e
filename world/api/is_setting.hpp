#pragma once

#include "world/api/robot_command.hpp"

namespace aprsim::api {

/// Whether the action only changes a setting: it takes effect at once, leaves the running motion
/// and its guards alone and has no guards of its own.
[[nodiscard]] inline bool is_setting(const RobotAction& action) {
  return std::holds_alternative<SetMotionLimit>(action) ||
         std::holds_alternative<SetOverride>(action) ||
         std::holds_alternative<SetGripperForce>(action);
}

}  // namespace aprsim::api
