#pragma once

#include <algorithm>

#include "world/robot/trajectory/limits/path_limits.hpp"

namespace aprsim::robot {

/// Limits of a path as a whole: the lowest of its segments.
class SegmentLimits {
 public:
  /// A segment on which the tool advances by `length_m` and turns by `angle_rad`. Returns its
  /// duration at full speed [s].
  double add(double length_m, double angle_rad, const ToolLimits& tool, const ToolLimits& maximum) {
    constexpr double kSmall = 1e-12;
    const double length = std::max(length_m, kSmall), angle = std::max(angle_rad, kSmall);
    const double duration = std::max(length / tool.trans_speed_m_s, angle / tool.rot_speed_rad_s);
    const auto accel = [&](const ToolLimits& limits) {
      return duration * std::min(limits.trans_accel_m_s2 / length, limits.rot_accel_rad_s2 / angle);
    };
    add(accel(tool), accel(maximum), tool);
    return duration;
  }
  /// A segment with a limit of the acceleration of its own time [1/s], as planned and for a hard
  /// stop.
  void add(double accel, double hard_accel, const ToolLimits& tool) {
    accel_ = std::min(accel_, accel);
    hard_accel_ = std::min(hard_accel_, hard_accel);
    tool_.trans_accel_m_s2 = std::min(tool_.trans_accel_m_s2, tool.trans_accel_m_s2);
    tool_.rot_accel_rad_s2 = std::min(tool_.rot_accel_rad_s2, tool.rot_accel_rad_s2);
  }

  [[nodiscard]] PathMove move(const JointVector& start, const JointLimits& joints) const {
    return {.start = start,
            .accel = accel_,
            .hard_accel = hard_accel_,
            .tool = tool_,
            .joints = joints};
  }

 private:
  static constexpr double kNone = 1e9;
  double accel_ = kNone, hard_accel_ = kNone;
  ToolLimits tool_{kNone, kNone, kNone, kNone};
};

}  // namespace aprsim::robot
