#pragma once

#include <array>
#include <cstdint>

#include "world/robot/double_s.hpp"
#include "world/robot/motion_limits.hpp"

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
};

/// Motion of all joints between two postures, jerk-limited, from rest to rest; or the stop of all
/// joints from any state. Never allocates. Thread: sim.
class JointMotion {
 public:
  void plan(const JointMove& move);
  /// Every joint for itself to rest, as fast as its limits allow and within its range.
  void plan_stop(const JointVector& q, const JointVector& qd, const JointVector& qdd,
                 const JointLimits& limits);
  /// To rest on the way; end() is then where that will be.
  void brake(Brake how);

  /// Advances by `dt` and writes the position. True once at rest at end(), then exactly.
  bool advance(double dt, JointVector& q);
  /// Position `t` seconds after the start or the last brake().
  void at(double t, JointVector& q) const;
  [[nodiscard]] const JointVector& end() const { return end_; }
  [[nodiscard]] double duration() const { return duration_; }

 private:
  [[nodiscard]] DoubleS& own(int joint) { return own_[static_cast<std::size_t>(joint)]; }
  [[nodiscard]] const DoubleS& own(int joint) const {
    return own_[static_cast<std::size_t>(joint)];
  }
  void plan_shared();
  void find_end();

  JointMove move_;
  JointVector way_;
  DoubleS shared_;  ///< share of the way made, 0 .. 1
  ScalarLimits shared_limits_, hard_limits_;
  std::array<DoubleS, kMaxDof> own_;
  JointVector end_;
  std::int64_t steps_ = 0;  ///< since the start or the last brake()
  double time_ = 0, duration_ = 0;
};

}  // namespace aprsim::robot
