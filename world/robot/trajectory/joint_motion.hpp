#pragma once

#include <array>
#include <cstdint>

#include "world/robot/trajectory/double_s.hpp"
#include "world/robot/trajectory/motion_limits.hpp"

namespace aprsim::robot {

/// How hard a motion is braked on its path.
enum class Brake {
  kSet,   ///< with the deceleration the motion was planned with
  kHard,  ///< with all that the joints may do
};

/// What a joint motion shall do.
struct JointMove {
  JointVector start, target;
  JointLimits limits;   ///< to plan with
  JointLimits maximum;  ///< to brake hard with
  /// Joints that run their own profile at their own limits. The others share one, so that they
  /// arrive together and move on a straight line in joint space.
  std::array<bool, kMaxDof> alone{};
  /// Caps on the share of the way that all joints together make in a second (1/s, 1/s^2).
  double share_speed = 1e9, share_accel = 1e9;
  /// Slows everything: speeds by it, accelerations by its square. In (0, 1].
  double pace = 1;
  /// State at the start, in motion; empty = at rest. Every joint then runs alone.
  JointVector qd{}, qdd{};
};

/// Motion of all joints to a posture, jerk-limited, from rest or in passing; or the stop of all
/// joints from any state. Never allocates. A copyable value. Thread: sim.
class JointMotion {
 public:
  void plan(const JointMove& move);
  /// Every joint for itself to rest, as fast as its limits allow and within its range.
  void plan_stop(const JointVector& q, const JointVector& qd, const JointVector& qdd,
                 const JointLimits& limits);
  /// To rest on the way; end() is then where that will be.
  void brake(Brake how);
  /// From now on so much of the full speed, 0..1; at 0 it comes to rest and waits.
  void set_speed(double fraction);
  /// How far the joints leave their ranges on the way [rad]: a motion that starts in passing may.
  [[nodiscard]] double beyond_range() const;

  /// Advances by `dt` and writes the position. True once at rest at end(), then exactly.
  bool advance(double dt, JointVector& q);
  /// Position `t` seconds after the start or the last change of the profiles.
  void at(double t, JointVector& q) const;
  [[nodiscard]] const JointMove& move() const { return move_; }
  [[nodiscard]] const JointVector& end() const { return end_; }
  [[nodiscard]] double duration() const { return duration_; }

 private:
  [[nodiscard]] DoubleS& own(int joint) { return own_[static_cast<std::size_t>(joint)]; }
  [[nodiscard]] const DoubleS& own(int joint) const {
    return own_[static_cast<std::size_t>(joint)];
  }
  [[nodiscard]] bool alone(int joint) const { return move_.alone[static_cast<std::size_t>(joint)]; }
  void plan_shared();
  void restart();

  JointMove move_;
  JointVector way_;
  DoubleS shared_;  ///< share of the way made, 0 .. 1
  ScalarLimits shared_limits_, hard_limits_;
  std::array<DoubleS, kMaxDof> own_;
  JointVector end_;
  std::int64_t steps_ = 0;  ///< since the start or the last change of the profiles
  double time_ = 0, duration_ = 0;
  double speed_ = 1;
  bool braking_ = false;
  bool shared_way_ = false;  ///< some joints share a profile
};

}  // namespace aprsim::robot
