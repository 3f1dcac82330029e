#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "world/robot/trajectory/joint_motion.hpp"
#include "world/robot/trajectory/limits/path_limits.hpp"
#include "world/robot/trajectory/path/ik_path.hpp"
#include "world/robot/trajectory/path/joint_path.hpp"
#include "world/robot/trajectory/profile/double_s.hpp"

namespace aprsim::robot {

/// Motion along a path from rest to rest, jerk-limited, slowed where a joint would be too fast. The
/// path is one of the tool (lines with blended corners, a helix), kept exactly, or one in joint
/// space. A redundant arm uses its freedom where the elbow angle cannot stay, or where it would
/// make the tool wait. A tool path from a singular start that its branch cannot leave begins with a
/// self-motion of the arm, while the tool rests. A copyable value; copies share the path. Thread:
/// any, one at a time.
class PathMotion {
 public:
  /// A new path to plan; it is built before plan().
  ToolPath& begin_tool_path(const Eigen::Isometry3d& X_FT);
  JointPath& begin_joint_path(const Eigen::Isometry3d& X_FT);

  /// Checks the whole path. Errors as IkPath::trace().
  [[nodiscard]] Result<void> plan(const ArmGeometry& arm, const PathMove& move);
  /// The same motion slowed: speeds by `scale`, accelerations by its square; only before it starts.
  void set_time_scale(double scale);
  /// Speed override 0..1 from now on; at 0 it comes to rest and waits.
  void set_speed(double fraction);
  /// To rest on the path; end() is then where that will be.
  void brake(const ArmGeometry& arm, Brake how);

  /// Advances by `dt` and writes the position. True once at rest at end(), then exactly.
  [[nodiscard]] bool advance(const ArmGeometry& arm, double dt, JointVector& q);
  /// Position `t` seconds after the start of the path itself or the last change of its profile;
  /// quick, good to some 1e-6 rad.
  [[nodiscard]] JointVector approximate_at(double t) const;
  /// Adds the positions from the start to the end at intervals of `interval_s`, both ends included;
  /// only before it starts.
  void sample(double interval_s, std::vector<JointVector>& out) const;
  /// Adds `count` positions on the way that is left, also where the speed override holds it.
  void remaining(std::size_t count, std::vector<JointVector>& out) const;
  [[nodiscard]] const JointVector& end() const { return end_; }
  /// Duration of the path itself.
  [[nodiscard]] double duration() const { return profile_.duration(); }
  /// With a self-motion before it.
  [[nodiscard]] double whole_duration() const {
    return duration() + (in_self_motion_ ? self_motion_.duration() : 0);
  }
  [[nodiscard]] bool is_planned() const { return path_ != nullptr && end_.size() > 0; }
  /// Adds what copies share: the path.
  void list(SharedParts& parts) const;

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [path, time_scale, speed, braking, profile, end, self_motion, in_self_motion, steps,
           time] = self;
    io(path, time_scale, speed, braking, profile, end, self_motion, in_self_motion, steps, time);
  }
  template <typename In>
  void require_valid(In& in) const {
    in.require(!in_self_motion_ || self_motion_.is_planned(), "a self-motion without a plan");
    in.require(time_scale_ > 0 && time_scale_ <= 1 && speed_ >= 0 && speed_ <= 1 && steps_ >= 0,
               "a speed override beyond 0 to 1");
    if (path_) in.all_joints(end_.size());
  }

 private:
  [[nodiscard]] Result<void> find_branch(const ArmGeometry& arm, const PathMove& move);
  [[nodiscard]] bool try_elbow_turn(const ArmGeometry& arm, const JointVector& start,
                                    double elbow_turn_rad);
  [[nodiscard]] bool try_all_postures(const ArmGeometry& arm, const JointVector& start);
  [[nodiscard]] bool try_guide(const ArmGeometry& arm, std::span<const JointVector> postures);
  [[nodiscard]] PathLimits choose_limits(const ArmGeometry& arm, const PathMove& move) const;
  void prefer_quicker_postures(const ArmGeometry& arm, const PathMove& move);
  void plan_self_motion(const PathMove& move, const JointVector& target);
  [[nodiscard]] JointVector approximate(double u) const;
  [[nodiscard]] double length_s() const;
  [[nodiscard]] std::span<const PathSample> samples() const;
  [[nodiscard]] JointVector position(const ArmGeometry& arm, double u) const;
  [[nodiscard]] ScalarLimits limits_now() const;
  void restart(const DoubleS& profile);

  /// Result of planning; constant once the motion runs.
  struct Path {
    bool in_joint_space = false;
    IkPath ik;
    Eigen::Isometry3d X_FT = Eigen::Isometry3d::Identity();
    JointPath joint;
    std::vector<PathSample> joint_samples;
    PathLimits limits;

    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [in_joint_space, ik, X_FT, joint, joint_samples, limits] = self;
      io(in_joint_space, ik, X_FT, joint, joint_samples, limits);
    }
    template <typename In>
    void require_valid(In& in) const {
      in.require(in_joint_space ? joint.is_complete() && !joint_samples.empty() : ik.is_complete(),
                 "an incomplete path");
      for (const PathSample& sample : joint_samples) in.all_joints(sample.q.size());
    }
  };

  std::shared_ptr<Path> path_;
  double time_scale_ = 1, speed_ = 1;
  bool braking_ = false;
  DoubleS profile_;  ///< of the scaled parameter
  JointVector end_;
  JointMotion self_motion_;  ///< out of a singular start
  bool in_self_motion_ = false;
  std::int64_t steps_ = 0;
  double time_ = 0;
};

}  // namespace aprsim::robot
