#pragma once

#include <array>

#include "world/robot/trajectory/profile/joint_limits.hpp"

namespace aprsim::robot {

/// Joints that apply a given torque towards a position. A drive in this mode advances at a limited
/// speed while the load torque is below the applied one, rests if both are equal, and yields to a
/// larger one. Gravity is compensated besides. A copyable value. Thread: sim.
class TorqueMode {
 public:
  struct Setpoint {
    int joint = 0;
    double target_rad = 0;
    double torque_nm = 0, rate_nm_s = 0;  ///< rate 0 = at once

    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [joint, target_rad, torque_nm, rate_nm_s] = self;
      io(joint, target_rad, torque_nm, rate_nm_s);
    }
    template <typename In>
    void require_valid(In& in) const {
      in.joint(joint);
    }
  };

  void clear() { count_ = 0; }
  /// From the joint's present position, at rest.
  void add(const Setpoint& setpoint, double position_rad);
  [[nodiscard]] bool active() const { return count_ > 0; }
  /// Every joint is at its target, or at rest in balance with its load.
  [[nodiscard]] bool settled() const;
  /// A joint that settled before its target; -1 = none.
  [[nodiscard]] int balanced_joint() const;

  struct StepInput {
    const JointLimits& limits;
    const JointVector& external_nm;  ///< contact torques on the joints; empty = none
    const JointVector& inertia;      ///< diagonal of the mass matrix
    double speed = 1;                ///< override
    double step_s = 1e-3;
  };
  /// One step: moves the joints of `q` that are in torque mode.
  void advance(const StepInput& input, JointVector& q);
  /// Torque that each joint in torque mode applies now [Nm], >= 0; the others 0.
  [[nodiscard]] JointVector applied_torque(int dof) const;

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [joints, count] = self;
    io(joints, count);
    io.require(count >= 0 && count <= kMaxDof, "more joints than an arm has");
  }

 private:
  struct DrivenJoint {
    Setpoint setpoint;
    double position = 0, speed = 0;
    double torque = 0;  ///< now, while it builds up
    bool at_target = false;
    int balanced_steps = 0;  ///< in a row; kBalanceReported once long enough

    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [setpoint, position, speed, torque, at_target, balanced_steps] = self;
      io(setpoint, position, speed, torque, at_target, balanced_steps);
    }
  };
  static constexpr int kBalanceReported = -1;
  void advance(DrivenJoint& joint, const StepInput& input) const;

  std::array<DrivenJoint, kMaxDof> joints_;
  int count_ = 0;
};

}  // namespace aprsim::robot
