#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>

#include "world/api/commands/robot_command.hpp"
#include "world/api/snapshot/snapshot.hpp"

namespace aprsim::robot {

/// Limits of the tool's motion in space; SI.
struct ToolLimits {
  double trans_speed_m_s = 0, trans_accel_m_s2 = 0;
  double rot_speed_rad_s = 0, rot_accel_rad_s2 = 0;

  [[nodiscard]] double of(api::MotionLimit which) const {
    switch (which) {
      case api::MotionLimit::kTransSpeed:
        return trans_speed_m_s;
      case api::MotionLimit::kTransAccel:
        return trans_accel_m_s2;
      case api::MotionLimit::kRotSpeed:
        return rot_speed_rad_s;
      case api::MotionLimit::kRotAccel:
        break;
    }
    return rot_accel_rad_s2;
  }

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [trans_speed_m_s, trans_accel_m_s2, rot_speed_rad_s, rot_accel_rad_s2] = self;
    io(trans_speed_m_s, trans_accel_m_s2, rot_speed_rad_s, rot_accel_rad_s2);
  }
};

/// The limits that moves of the tool obey, as set by commands. At start 0.25 m/s, 2 m/s^2, 1 rad/s
/// and 5 rad/s^2, or the robot's maximum where that is lower.
class ToolLimitSettings {
 public:
  explicit ToolLimitSettings(const ToolLimits& maximum);

  /// A value > 0, or a fraction in (0, 1], of the maximum. A value above the maximum is clamped to
  /// it.
  void set(const api::SetMotionLimit& setting);

  [[nodiscard]] api::LimitSetting get(api::MotionLimit which) const {
    return settings_[index(which)];
  }
  [[nodiscard]] ToolLimits effective() const { return effective({}); }
  /// The same with what a pose sets for the way to it; clamped to the maximum.
  [[nodiscard]] ToolLimits effective(const api::PoseLimits& own) const {
    return {value(api::MotionLimit::kTransSpeed, own.trans_speed),
            value(api::MotionLimit::kTransAccel, own.trans_accel),
            value(api::MotionLimit::kRotSpeed, own.rot_speed),
            value(api::MotionLimit::kRotAccel, own.rot_accel)};
  }
  [[nodiscard]] const ToolLimits& maximum() const { return maximum_; }

  static ToolLimitSettings blank() { return ToolLimitSettings({1, 1, 1, 1}); }
  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [maximum, settings] = self;
    io(maximum, settings);
  }
  template <typename In>
  void require_valid(In& in) const {
    const ToolLimits& m = maximum_;
    in.require(m.trans_speed_m_s > 0 && m.trans_accel_m_s2 > 0 && m.rot_speed_rad_s > 0 &&
                   m.rot_accel_rad_s2 > 0,
               "a limit of the tool that is not above 0");
    for (const api::LimitSetting& setting : settings_) {
      in.require(setting.value > 0, "a limit of the tool that is not above 0");
    }
  }

 private:
  static std::size_t index(api::MotionLimit which) { return static_cast<std::size_t>(which); }
  [[nodiscard]] double value(api::MotionLimit which,
                             const std::optional<api::LimitSetting>& own) const {
    const api::LimitSetting setting = own.value_or(get(which));
    const double highest = maximum_.of(which);
    return std::min(highest, setting.relative ? setting.value * highest : setting.value);
  }

  ToolLimits maximum_;
  std::array<api::LimitSetting, 4> settings_;  // by MotionLimit
};

}  // namespace aprsim::robot
