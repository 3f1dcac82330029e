#include "world/robot/planning/tool_limit_settings.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace aprsim::robot {
namespace {

constexpr std::array kAll{api::MotionLimit::kTransSpeed, api::MotionLimit::kTransAccel,
                          api::MotionLimit::kRotSpeed, api::MotionLimit::kRotAccel};
/// In the order of kAll [m/s, m/s^2, rad/s, rad/s^2].
constexpr std::array kAtStart{0.25, 2.0, 1.0, 5.0};

/// For messages.
const char* name_of(api::MotionLimit which) {
  switch (which) {
    case api::MotionLimit::kTransSpeed:
      return "translation speed";
    case api::MotionLimit::kTransAccel:
      return "translation acceleration";
    case api::MotionLimit::kRotSpeed:
      return "rotation speed";
    case api::MotionLimit::kRotAccel:
      return "rotation acceleration";
  }
  throw std::logic_error("unknown motion limit");
}

/// One of the four limits.
double part(const ToolLimits& limits, api::MotionLimit which) {
  switch (which) {
    case api::MotionLimit::kTransSpeed:
      return limits.trans_speed_m_s;
    case api::MotionLimit::kTransAccel:
      return limits.trans_accel_m_s2;
    case api::MotionLimit::kRotSpeed:
      return limits.rot_speed_rad_s;
    case api::MotionLimit::kRotAccel:
      return limits.rot_accel_rad_s2;
  }
  throw std::logic_error("unknown motion limit");
}

std::size_t index(api::MotionLimit which) { return static_cast<std::size_t>(which); }

}  // namespace

ToolLimitSettings::ToolLimitSettings(const ToolLimits& maximum) : maximum_(maximum) {
  for (const auto which : kAll) {
    const double highest = part(maximum, which);
    if (!(highest > 0) || !std::isfinite(highest)) {
      throw std::invalid_argument(std::string("the robot's maximal ") + name_of(which) +
                                  " must be > 0");
    }
    settings_[index(which)] = {false, std::min(highest, kAtStart[index(which)])};
  }
}

/// A fraction refers to the maximum and stays a fraction.
void ToolLimitSettings::set(const api::SetMotionLimit& setting) {
  const double value =
      setting.relative ? setting.value : std::min(setting.value, part(maximum_, setting.which));
  settings_[index(setting.which)] = {setting.relative, value};
}

api::LimitSetting ToolLimitSettings::get(api::MotionLimit which) const {
  return settings_[index(which)];
}

double ToolLimitSettings::value(api::MotionLimit which,
                                const std::optional<api::LimitSetting>& own) const {
  const api::LimitSetting setting = own.value_or(settings_[index(which)]);
  const double highest = part(maximum_, which);
  return std::min(highest, setting.relative ? setting.value * highest : setting.value);
}

ToolLimits ToolLimitSettings::effective() const { return effective({}); }

ToolLimits ToolLimitSettings::effective(const api::PoseLimits& own) const {
  return {value(api::MotionLimit::kTransSpeed, own.trans_speed),
          value(api::MotionLimit::kTransAccel, own.trans_accel),
          value(api::MotionLimit::kRotSpeed, own.rot_speed),
          value(api::MotionLimit::kRotAccel, own.rot_accel)};
}

}  // namespace aprsim::robot
