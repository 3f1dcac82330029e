#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "world/robot/trajectory/double_s.hpp"
#include "world/robot/trajectory/ik_path.hpp"
#include "world/robot/trajectory/joint_motion.hpp"
#include "world/robot/trajectory/joint_path.hpp"
#include "world/robot/trajectory/time_scaling.hpp"

namespace aprsim::robot {

/// How a motion along a path is to run.
struct PathMove {
  JointVector start;
  /// Acceleration of the path's own time s that the tool's limits allow, and the most that a hard
  /// stop may take [1/s].
  double accel = 0, hard_accel = 0;
  ToolLimits tool;  ///< what corners keep to
  JointLimits joints;
};

/// Motion along a path from rest to rest, jerk-limited, slowed where a joint would be too fast. The
/// path is one of the tool (lines with rounded corners, a helix), followed exactly, or one of the
/// joints. A tool path that starts in a singular posture that it cannot leave begins with the turn
/// of the free joints that it needs; the tool rests meanwhile. A copyable value. Thread: sim.
class PathMotion {
 public:
  PathMotion();

  /// The path to plan; it is laid before plan().
  ToolPath& lay_tool_path(const Eigen::Isometry3d& X_FT);
  JointPath& lay_joint_path(const Eigen::Isometry3d& X_FT);

  /// Checks the whole path. Errors as IkPath::trace().
  [[nodiscard]] Result<void> plan(const ArmGeometry& arm, const PathMove& move);
  /// The same motion slowed: speeds by `pace`, accelerations by its square; only before it starts.
  void set_pace(double pace);
  /// From now on so much of the full speed, 0..1; at 0 it comes to rest and waits.
  void set_speed(double fraction);
  /// To rest on the path; end() is then where that will be.
  void brake(const ArmGeometry& arm, Brake how);

  /// Advances by `dt` and writes the position. True once at rest at end(), then exactly.
  [[nodiscard]] bool advance(const ArmGeometry& arm, double dt, JointVector& q);
  /// Position `t` seconds after the start of the path itself or the last change of its profile;
  /// quick, good to some 1e-6 rad.
  [[nodiscard]] JointVector roughly_at(double t) const;
  [[nodiscard]] const JointVector& end() const { return end_; }
  [[nodiscard]] double duration() const { return profile_.duration(); }

 private:
  [[nodiscard]] Result<void> find_path(const ArmGeometry& arm, const PathMove& move);
  [[nodiscard]] IkPath::Route route(const ArmGeometry& arm, const JointVector& start,
                                    double elbow_turn_rad) const;
  [[nodiscard]] bool try_elbow(const ArmGeometry& arm, const JointVector& start,
                               double elbow_turn_rad);
  void plan_turn(const PathMove& move, const JointVector& target);
  [[nodiscard]] bool tool_rests(const ArmGeometry& arm, const JointVector& from,
                                const JointVector& to) const;
  void sample_joint_path();
  void choose_limits(const ArmGeometry& arm, const PathMove& move);
  void choose_rates(const ArmGeometry& arm, const PathMove& move);
  [[nodiscard]] TimeScaling::Knot knot_at(const ArmGeometry& arm, const PathMove& move,
                                          const IkPath::Sample& sample) const;
  [[nodiscard]] bool runs_up(double u) const;
  [[nodiscard]] bool runs_free(const ArmGeometry& arm, const PathMove& move) const;
  [[nodiscard]] double typical_accel(const JointLimits& joints) const;
  [[nodiscard]] double spare_accel(const JointLimits& joints) const;
  [[nodiscard]] ToolPath::Curvature tool_bend(const ArmGeometry& arm,
                                              const IkPath::Sample& sample) const;
  [[nodiscard]] const BlendedSegments& chain() const;
  [[nodiscard]] std::span<const IkPath::Sample> samples() const;
  [[nodiscard]] JointVector position(const ArmGeometry& arm, double u) const;
  [[nodiscard]] ScalarLimits limits_now() const;
  void restart(const DoubleS& profile);

  bool of_joints_ = false;
  IkPath tool_path_;
  Eigen::Isometry3d X_FT_ = Eigen::Isometry3d::Identity();
  JointPath joint_path_;
  std::vector<IkPath::Sample> joint_samples_;
  TimeScaling stretch_;
  std::vector<TimeScaling::Knot> knots_;
  ScalarLimits limits_, hard_limits_;  ///< of the stretched parameter, at pace 1
  double pace_ = 1, speed_ = 1;
  bool braking_ = false;
  DoubleS profile_;
  JointVector end_;
  JointMotion turn_;  ///< out of a singular start
  bool turning_ = false;
  std::int64_t steps_ = 0;
  double time_ = 0;
};

}  // namespace aprsim::robot
