#include "world/robot/trajectory/limits/tool_limits.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

namespace aprsim::robot {
namespace {

struct AtStart {
  api::MotionLimit which;
  double value;  ///< [m/s, m/s^2, rad/s, rad/s^2]
  const char* name;
};
constexpr AtStart kAtStart[] = {
    {api::MotionLimit::kTransSpeed, 0.25, "translation speed"},
    {api::MotionLimit::kTransAccel, 2, "translation acceleration"},
    {api::MotionLimit::kRotSpeed, 1, "rotation speed"},
    {api::MotionLimit::kRotAccel, 5, "rotation acceleration"},
};

}  // namespace

ToolLimitSettings::ToolLimitSettings(const ToolLimits& maximum) : maximum_(maximum) {
  for (const auto& [which, value, name] : kAtStart) {
    // A default above the robot's maximum would be exceeded by its own first motion.
    const double highest = maximum.of(which);
    if (!(highest > 0) || !std::isfinite(highest)) {
      throw std::invalid_argument(std::string("the robot's maximal ") + name + " must be > 0");
    }
    settings_[index(which)] = {false, std::min(highest, value)};
  }
}

void ToolLimitSettings::set(const api::SetMotionLimit& setting) {
  // CRCL sets limits absolutely or as a fraction of the maximum.
  const double value =
      setting.relative ? setting.value : std::min(setting.value, maximum_.of(setting.which));
  settings_[index(setting.which)] = {setting.relative, value};
}

}  // namespace aprsim::robot
