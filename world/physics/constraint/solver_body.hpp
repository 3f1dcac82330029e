#pragma once

#include <Eigen/Core>

namespace aprsim::physics {

/// Velocity of a body: of its centre of mass, and of its rotation.
struct Twist {
  Eigen::Vector3d v = Eigen::Vector3d::Zero(), omega = Eigen::Vector3d::Zero();
};

/// A body of ContactSolver. SI, world axes.
struct SolverBody {
  double inverse_kg = 0, kg = 0;
  Eigen::Matrix3d inverse_inertia = Eigen::Matrix3d::Zero(), inertia = Eigen::Matrix3d::Zero();
  Eigen::Vector3d com = Eigen::Vector3d::Zero();
  Twist free, twist;
  Twist searched;       ///< while the other one belongs to the impulses
  int unknown = -1;     ///< number among those that move
  bool driven = false;  ///< by rows

  [[nodiscard]] bool moves() const { return unknown >= 0; }
  /// Gives it an impulse.
  void push(const Eigen::Vector3d& impulse, const Eigen::Vector3d& moment) {
    twist.v += inverse_kg * impulse;
    twist.omega += inverse_inertia * moment;
  }
};

}  // namespace aprsim::physics
