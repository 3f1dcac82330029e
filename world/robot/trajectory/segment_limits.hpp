#pragma once

#include <algorithm>

#include "world/robot/trajectory/path_motion.hpp"

namespace aprsim::robot {

/// Gathers from the segments of a path what the path as a whole may do.
class SegmentLimits {
 public:
  /// A further segment on which the tool goes `length_m` (or, for a joint path, up to so much per
  /// share of the segment) and turns `angle_rad`. Returns how long it takes at full speed [s].
  double take(double length_m, double angle_rad, const ToolLimits& tool,
              const ToolLimits& maximum) {
    constexpr double kSmall = 1e-12;
    const double length = std::max(length_m, kSmall), angle = std::max(angle_rad, kSmall);
    const double duration = std::max(length / tool.trans_speed_m_s, angle / tool.rot_speed_rad_s);
    const auto accel = [&](const ToolLimits& limits) {
      return duration * std::min(limits.trans_accel_m_s2 / length, limits.rot_accel_rad_s2 / angle);
    };
    take(accel(tool), accel(maximum), tool);
    return duration;
  }
  /// A further segment whose time may change its pace by `accel` [1/s].
  void take(double accel, double hard_accel, const ToolLimits& tool) {
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
