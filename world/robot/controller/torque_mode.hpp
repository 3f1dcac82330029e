#pragma once

#include <array>

#include "world/robot/trajectory/motion_limits.hpp"

namespace aprsim::robot {

/// Joints that press towards a position with a given torque. A drive in this mode advances at a
/// limited speed as long as what it meets bears less than its torque, rests where both are equal,
/// and gives way to more. Gravity is carried besides. A copyable value. Thread: sim.
class TorqueMode {
 public:
  struct Order {
    int joint = 0;
    double target_rad = 0;
    double torque_nm = 0, rate_nm_s = 0;  ///< rate 0 = at once
  };

  void clear() { count_ = 0; }
  /// From the joint's present position, at rest.
  void add(const Order& order, double position_rad);
  [[nodiscard]] bool active() const { return count_ > 0; }
  /// Every joint is at its target or has stood still in balance for a while.
  [[nodiscard]] bool settled() const;
  /// A joint that settled before its target; -1 = none.
  [[nodiscard]] int balanced_joint() const;

  struct Surroundings {
    const JointLimits& limits;
    const JointVector& external_nm;  ///< contact torques on the joints; empty = none
    const JointVector& inertia;      ///< diagonal of the mass matrix
    double speed = 1;                ///< override
    double step_s = 1e-3;
  };
  /// One step: moves the driven joints of `q`.
  void advance(const Surroundings& world, JointVector& q);
  /// What the drives press with now, for the joints that are driven so; the others 0.
  [[nodiscard]] JointVector pressing(int dof) const;

 private:
  struct Axis {
    Order order;
    double position = 0, speed = 0;
    double torque = 0;  ///< now, while it builds up
    bool there = false;
    int balanced_steps = 0;
  };
  void advance(Axis& axis, const Surroundings& world) const;

  std::array<Axis, kMaxDof> axes_;
  int count_ = 0;
};

}  // namespace aprsim::robot
