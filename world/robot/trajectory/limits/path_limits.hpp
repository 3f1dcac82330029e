#pragma once

#include <span>
#include <vector>

#include "world/robot/trajectory/limits/tool_limits.hpp"
#include "world/robot/trajectory/path/path_sample.hpp"
#include "world/robot/trajectory/path/tool_path.hpp"
#include "world/robot/trajectory/profile/double_s.hpp"
#include "world/robot/trajectory/profile/joint_limits.hpp"
#include "world/robot/trajectory/profile/time_scaling.hpp"

namespace aprsim::robot {

/// How a motion along a path is to run.
struct PathMove {
  JointVector start;
  /// Acceleration of the path's own time s that the tool's limits allow, and the most for a hard
  /// stop [1/s].
  double accel = 0, hard_accel = 0;
  ToolLimits tool;  ///< kept in corners
  JointLimits joints;
};

/// A path with its samples over the whole of u = s / length. A view; valid as long as its parts.
struct SampledPath {
  const ArmModel& model;
  const Eigen::Isometry3d& X_FT;
  const ToolPath* tool_path;  ///< null for a path in joint space
  double length_s;
  std::span<const PathSample> samples;
};

/// The limits of the profile that runs along a path, and the time scaling that slows it where a
/// joint or the tool would exceed its own limits (corners, singular postures). At full rate the
/// joints have
///     qd = q' v,   qdd = q'' v^2 + q' a,   qddd = q''' v^3 + 3 q'' v a + q' j
/// for a profile with velocity v, acceleration a and jerk j. A path that keeps all limits so is not
/// slowed. A copyable value. Thread: sim.
class PathLimits {
 public:
  void choose(const SampledPath& path, const PathMove& move);

  /// Limits of the profile along the scaled parameter, as planned and for a hard stop.
  [[nodiscard]] const ScalarLimits& planned() const { return planned_; }
  [[nodiscard]] const ScalarLimits& hard() const { return hard_; }
  [[nodiscard]] const TimeScaling& scaling() const { return scaling_; }

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [planned, hard, scaling] = self;
    io(planned, hard, scaling);
  }

 private:
  [[nodiscard]] bool in_ramp(double u) const;
  [[nodiscard]] bool keeps_limits(const SampledPath& path, const PathMove& move) const;
  [[nodiscard]] double spare_accel(const SampledPath& path, const JointLimits& joints) const;
  [[nodiscard]] TimeScaling::RateLimit rate_limit(const SampledPath& path, const PathMove& move,
                                                  const PathSample& sample) const;
  void limit_rates(const SampledPath& path, const PathMove& move);

  ScalarLimits planned_, hard_;
  TimeScaling scaling_;
};

}  // namespace aprsim::robot
