#pragma once

#include <fmt/format.h>

#include "world/api/commands/motion_command.hpp"
#include "world/base/result.hpp"

/// Speed limits of manual operation, as in mode T1 of a real controller.
namespace aprsim::web {

/// Reduced speed of ISO 10218-1, 5.7.3, at the tool.
inline constexpr double kManualSpeed_m_s = 0.25;
/// Angular speed at which a point 0.25 m from the tool point has that speed.
inline constexpr double kManualTurn_rad_s = 1;

/// A share of these speeds as the limits of one move. Field: "speed".
[[nodiscard]] inline Result<api::PoseLimits> manual_limits(double share) {
  if (!(share > 0 && share <= 1)) {
    return fail(ErrorCode::kInvalidArgument, "speed",
                fmt::format("{} is not above 0 and up to 1", share));
  }
  api::PoseLimits limits;
  limits.trans_speed = {.relative = false, .value = share * kManualSpeed_m_s};
  limits.rot_speed = {.relative = false, .value = share * kManualTurn_rad_s};
  return limits;
}

}  // namespace aprsim::web
