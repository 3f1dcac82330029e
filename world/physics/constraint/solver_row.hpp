#pragma once

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

namespace aprsim::physics {

/// A scalar row of a ContactProblem: a joint's constraint, a drive or a limit, whose impulse stays
/// within bounds.
struct SolverRow {
  /// One side of it: its velocity is linear . v + angular . omega.
  struct Side {
    int body = -1;  ///< -1 = fixed to the world
    Eigen::Vector3d linear = Eigen::Vector3d::Zero(), angular = Eigen::Vector3d::Zero();
  };

  // ---- as it was added
  Side a, b;
  double target = 0, compliance = 0, lower = 0, upper = 0;
  bool is_angular = false;  ///< between rotations only
  double last_gamma = 0;    ///< of the last step
  double delassus = 0;      ///< diagonal of J M^-1 J'
  int pair = -1;            ///< its two bodies' pair of blocks in Newton's matrix

  // ---- the iterate
  double gamma = 0, proximal_gamma = 0;  ///< impulse, and its proximal point
  double v_c = 0,
         delta_v_c = 0;       ///< constraint velocity J V - target; its change along a direction
  double regularization = 0;  ///< compliance with the proximal term
  double G = 0;               ///< -d gamma / d v_c
  double assembled_G = 0;     ///< the one in Newton's matrix

  void set_proximal_weight(double weight) { regularization = compliance + weight * delassus; }
  /// The impulse that belongs to the velocity v_c + step * delta_v_c, and its derivative.
  void evaluate_impulse(double step) {
    if (!(regularization > 0)) return;
    const double v = v_c + step * delta_v_c;
    // R gamma = (R - compliance) proximal_gamma - v_c, then within bounds.
    const double z = ((regularization - compliance) * proximal_gamma - v) / regularization;
    gamma = std::clamp(z, lower, upper);
    G = z > lower && z < upper ? 1 / regularization : 0;
  }
  /// Natural map of the complementarity, in units of velocity.
  [[nodiscard]] double residual(double angular_lever_m) const {
    if (!(delassus > 0)) return 0;
    const double v = v_c + compliance * gamma;
    const double projected = std::clamp(gamma - v / delassus, lower, upper);
    return (is_angular ? angular_lever_m : 1) * delassus * std::abs(gamma - projected);
  }
};

}  // namespace aprsim::physics
