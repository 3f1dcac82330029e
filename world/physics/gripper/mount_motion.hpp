#pragma once

#include <Eigen/Geometry>

namespace aprsim::physics {

/// Pose of a gripper's tool frame T without the mount's deflection, and its motion in a step.
struct MountMotion {
  Eigen::Isometry3d X_WT = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d X_WT_next = Eigen::Isometry3d::Identity();  ///< at the end of the step
  Eigen::Isometry3d delta = Eigen::Isometry3d::Identity();      ///< X_WT_next X_WT^-1
  Eigen::Vector3d omega_W = Eigen::Vector3d::Zero();            ///< [rad/s]

  [[nodiscard]] static MountMotion at_rest(const Eigen::Isometry3d& X_WT) {
    return {.X_WT = X_WT, .X_WT_next = X_WT};
  }
  void begin_step(const Eigen::Isometry3d& X_WT_at_end, double step_s) {
    X_WT_next = X_WT_at_end;
    delta = X_WT_next * X_WT.inverse();
    const Eigen::AngleAxisd turn(delta.linear());
    omega_W = turn.angle() / step_s * turn.axis();
  }
  void end_step() { X_WT = X_WT_next; }
  /// Velocity of what is at `p_W` and moves with the mount.
  [[nodiscard]] Eigen::Vector3d velocity_at(const Eigen::Vector3d& p_W, double step_s) const {
    return (delta * p_W - p_W) / step_s;
  }

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [X_WT, X_WT_next, delta, omega_W] = self;
    io(X_WT, X_WT_next, delta, omega_W);
  }
};

}  // namespace aprsim::physics
