#pragma once

#include <Eigen/Core>

namespace aprsim::physics {

/// Velocity of a body: of its centre of mass, and of its rotation.
struct Twist {
  Eigen::Vector3d v = Eigen::Vector3d::Zero(), omega = Eigen::Vector3d::Zero();
};

/// A body of a ContactProblem. SI, world axes.
struct SolverBody {
  double inverse_kg = 0, kg = 0;
  Eigen::Matrix3d inverse_inertia = Eigen::Matrix3d::Zero(), inertia = Eigen::Matrix3d::Zero();
  Eigen::Vector3d com = Eigen::Vector3d::Zero();
  Twist free_twist;       ///< V_free: at the end of the step without impulses
  Twist twist;            ///< V: of the current iterate; the solution at the end
  Twist newton_twist;     ///< Newton's iterate, while `twist` follows from the impulses
  int unknown = -1;       ///< number among the bodies that move, -1 = kinematic
  bool actuated = false;  ///< a row acts on it

  [[nodiscard]] bool moves() const { return unknown >= 0; }
  /// Applies an impulse.
  void apply_impulse(const Eigen::Vector3d& impulse, const Eigen::Vector3d& moment) {
    twist.v += inverse_kg * impulse;
    twist.omega += inverse_inertia * moment;
  }
};

}  // namespace aprsim::physics
