#pragma once

#include <array>
#include <optional>

#include "world/api/robot_command.hpp"
#include "world/api/snapshot.hpp"
#include "world/robot/trajectory/motion_limits.hpp"

namespace aprsim::robot {

/// The limits that moves of the tool obey, as set by commands. At start 0.25 m/s, 2 m/s^2, 1 rad/s
/// and 5 rad/s^2, or the robot's maximum where that is lower.
class ToolLimitSettings {
 public:
  explicit ToolLimitSettings(const ToolLimits& maximum);

  /// A value > 0, or a fraction in (0, 1]. A value above the maximum is clamped to it.
  void set(const api::SetMotionLimit& setting);

  [[nodiscard]] api::LimitSetting get(api::MotionLimit which) const;
  [[nodiscard]] ToolLimits effective() const;
  /// The same with what a pose sets for the way to it; clamped to the maximum.
  [[nodiscard]] ToolLimits effective(const api::PoseLimits& own) const;
  [[nodiscard]] const ToolLimits& maximum() const { return maximum_; }

 private:
  [[nodiscard]] double value(api::MotionLimit which,
                             const std::optional<api::LimitSetting>& own = {}) const;

  ToolLimits maximum_;
  std::array<api::LimitSetting, 4> settings_;
};

}  // namespace aprsim::robot
