#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "world/robot/trajectory/profile/double_s.hpp"
#include "world/robot/trajectory/profile/joint_limits.hpp"

namespace aprsim::robot {

/// How hard a motion is braked on its path.
enum class Brake {
  kSet,   ///< with the deceleration the motion was planned with
  kHard,  ///< at the joints' limits
};
/// For checks of states (world/archive).
[[nodiscard]] constexpr Brake last_of(Brake) { return Brake::kHard; }

/// Task of a joint motion.
struct JointMove {
  JointVector start, target;
  JointLimits limits;   ///< to plan with
  JointLimits maximum;  ///< to brake hard with
  /// Joints with a profile of their own at their own limits. The others are synchronised: they
  /// share a profile of the progress 0..1, arrive together and move on a straight line in joint
  /// space.
  std::array<bool, kMaxDof> independent{};
  /// Limits of the shared profile (1/s, 1/s^2).
  double progress_speed = 1e9, progress_accel = 1e9;
  /// Factor on the speeds, its square on the accelerations; in (0, 1].
  double time_scale = 1;
  /// Velocity and acceleration at the start; empty = at rest. Every joint is then independent.
  JointVector qd{}, qdd{};

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [start, target, limits, maximum, independent, progress_speed, progress_accel, time_scale,
           qd, qdd] = self;
    io(start, target, limits, maximum, independent, progress_speed, progress_accel, time_scale, qd,
       qdd);
  }
};

/// Motion of all joints to a posture, jerk-limited, from any state; or the stop of all joints from
/// any state. Never allocates. A copyable value. Thread: sim.
class JointMotion {
 public:
  void plan(const JointMove& move);
  /// Every joint independently to rest, as fast as its limits allow and within its range.
  void plan_stop(const JointVector& q, const JointVector& qd, const JointVector& qdd,
                 const JointLimits& limits);
  /// To rest on the way; end() is then where that will be.
  void brake(Brake how);
  /// Speed override 0..1 from now on; at 0 it comes to rest and waits.
  void set_speed(double fraction);
  /// Largest excursion of a joint beyond its range on the way [rad]: possible from a moving start.
  [[nodiscard]] double beyond_range() const;

  /// Advances by `dt` and writes the position. True once at rest at end(), then exactly.
  bool advance(double dt, JointVector& q);
  /// Position `t` seconds after the start or the last change of the profiles.
  void at(double t, JointVector& q) const;
  /// Adds the positions from now to the end at intervals of `interval_s`, both ends included.
  void sample(double interval_s, std::vector<JointVector>& out) const;
  /// Adds `count` positions on the way that is left, also where the speed override holds it.
  void remaining(std::size_t count, std::vector<JointVector>& out) const;
  [[nodiscard]] const JointMove& move() const { return move_; }
  [[nodiscard]] const JointVector& end() const { return end_; }
  [[nodiscard]] double duration() const { return duration_; }
  /// Since the start or the last change of the profiles.
  [[nodiscard]] double time() const { return time_; }
  /// Time that its synchronised joints decelerate at the end, at most.
  [[nodiscard]] double deceleration_s() const;
  [[nodiscard]] bool is_planned() const { return end_.size() > 0; }

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [move, delta, shared, shared_limits, hard_limits, own, end, steps, time, duration, speed,
           braking, any_synchronised] = self;
    io(move, delta, shared, shared_limits, hard_limits, own, end, steps, time, duration, speed,
       braking, any_synchronised);
  }
  template <typename In>
  void require_valid(In& in) const {
    in.require(!is_planned() || has_consistent_sizes(), "an incomplete motion of joints");
    in.require(steps_ >= 0 && speed_ >= 0 && speed_ <= 1, "a speed override beyond 0 to 1");
  }

 private:
  [[nodiscard]] DoubleS& own(int joint) { return own_[static_cast<std::size_t>(joint)]; }
  [[nodiscard]] const DoubleS& own(int joint) const {
    return own_[static_cast<std::size_t>(joint)];
  }
  [[nodiscard]] bool independent(int joint) const {
    return move_.independent[static_cast<std::size_t>(joint)];
  }
  void plan_shared();
  void restart();
  /// Whether all vectors that advancing needs have the size of end().
  [[nodiscard]] bool has_consistent_sizes() const;

  JointMove move_;
  JointVector delta_;
  DoubleS shared_;  ///< progress of the synchronised joints, 0 .. 1
  ScalarLimits shared_limits_, hard_limits_;
  std::array<DoubleS, kMaxDof> own_;
  JointVector end_;
  std::int64_t steps_ = 0;  ///< since the start or the last change of the profiles
  double time_ = 0, duration_ = 0;
  double speed_ = 1;
  bool braking_ = false;
  bool any_synchronised_ = false;
};

}  // namespace aprsim::robot
