#pragma once

#include <cstdint>
#include <vector>

#include "world/robot/double_s.hpp"
#include "world/robot/joint_motion.hpp"
#include "world/robot/line_path.hpp"
#include "world/robot/path_stretch.hpp"

namespace aprsim::robot {

/// What a straight motion shall do.
struct LineMove {
  JointVector start;
  Eigen::Isometry3d X_BT_end = Eigen::Isometry3d::Identity();
  ToolLimits tool;      ///< to plan with
  ToolLimits tool_max;  ///< to brake hard with
  JointLimits joints;
  double pace = 1;  ///< slows everything: speeds by it, accelerations by its square; in (0, 1]
};

/// Straight line of the tool from rest to rest, jerk-limited along the line, slowed where a joint
/// would be too fast. A start in a singular posture that the line cannot leave begins with the turn
/// of the free joints that it needs; the tool rests meanwhile. Thread: sim.
class LineMotion {
 public:
  LineMotion(const ArmModel& model, const InverseKinematics& ik, const Eigen::Isometry3d& X_FT);

  /// Checks the whole line. Errors as LinePath::trace().
  [[nodiscard]] Result<void> plan(const LineMove& move);
  /// The same motion at another pace; only before it starts.
  void set_pace(double pace);
  /// To rest on the line; end() is then where that will be.
  void brake(Brake how);

  /// Advances by `dt` and writes the position. True once at rest at end(), then exactly.
  [[nodiscard]] bool advance(double dt, JointVector& q);
  /// Position `t` seconds after the start of the line itself or the last brake().
  [[nodiscard]] JointVector at(double t) const;
  /// The same, quick and good to some 1e-6 rad.
  [[nodiscard]] JointVector roughly_at(double t) const;
  [[nodiscard]] const JointVector& end() const { return end_; }
  [[nodiscard]] double duration() const { return profile_.duration(); }
  [[nodiscard]] const PathStretch& stretch() const { return stretch_; }

 private:
  [[nodiscard]] Result<void> find_path(const LineMove& move);
  [[nodiscard]] LinePath::Route route(const LineMove& move, const JointVector& start,
                                      double elbow_turn_rad) const;
  [[nodiscard]] bool try_elbow(const LineMove& move, double elbow_turn_rad);
  void plan_turn(const LineMove& move, const JointVector& target);
  [[nodiscard]] bool tool_rests(const JointVector& from, const JointVector& to) const;
  void choose_limits(const LineMove& move);
  void choose_rates(const JointLimits& joints);
  [[nodiscard]] double typical_accel(const JointLimits& joints) const;
  [[nodiscard]] double spare_accel(const JointLimits& joints) const;

  const ArmModel& model_;
  const InverseKinematics& ik_;
  Eigen::Isometry3d X_FT_;
  LinePath path_;
  PathStretch stretch_;
  std::vector<PathStretch::Knot> knots_;
  ScalarLimits limits_, hard_limits_;  ///< of the stretched parameter, at pace 1
  double pace_ = 1;
  DoubleS profile_;
  JointVector end_;
  JointMotion turn_;  ///< out of a singular start
  bool turning_ = false;
  std::int64_t steps_ = 0;
  double time_ = 0;
};

}  // namespace aprsim::robot
