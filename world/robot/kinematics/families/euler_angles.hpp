#pragma once

#include <cmath>

#include <Eigen/Geometry>

/// Closed-form Euler angles of a rotation about two axes (Siciliano et al. 2009, sec. 2.4.1). The
/// last angle is computed from the rotation that remains after the first two, so the product is
/// exact also close to the singular middle angle, where the first angle is ill-conditioned.
namespace aprsim::robot {

inline constexpr double kSingularSine = 1e-10;  ///< of the middle angle; below, `seed` decides

struct EulerAngles {
  double first = 0, middle = 0, last = 0;
};

/// R = Rx(first) Ry(middle) Rx(last), the middle angle having the sign of `side`. Where it is 0 or
/// pi the first angle is free and becomes `seed`.
[[nodiscard]] inline EulerAngles split_xyx(const Eigen::Matrix3d& R, double side, double seed) {
  const double s2 = side * std::sqrt(R(1, 0) * R(1, 0) + R(2, 0) * R(2, 0)), c2 = R(0, 0);
  const bool free = std::abs(s2) < kSingularSine;
  const double s1 = free ? std::sin(seed) : R(1, 0) / s2;
  const double c1 = free ? std::cos(seed) : -R(2, 0) / s2;
  // Second column of (Rx(first) Ry(middle))^T R.
  const double y = c1 * R(1, 1) + s1 * R(2, 1);
  const double z = s2 * R(0, 1) + c2 * (c1 * R(2, 1) - s1 * R(1, 1));
  return {free ? seed : std::atan2(s1, c1), std::atan2(s2, c2), std::atan2(z, y)};
}

/// R = Ry(first) Rz(middle) Ry(last); see split_xyx(), of which it is the cyclic exchange of axes.
[[nodiscard]] inline EulerAngles split_yzy(const Eigen::Matrix3d& R, double side, double seed) {
  Eigen::Matrix3d Q;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) Q(i, j) = R((i + 1) % 3, (j + 1) % 3);
  }
  return split_xyx(Q, side, seed);
}

/// R = Rz(first) Ry(middle) Rz(last); see split_xyx().
[[nodiscard]] inline EulerAngles split_zyz(const Eigen::Matrix3d& R, double side, double seed) {
  const double s2 = side * std::sqrt(R(0, 2) * R(0, 2) + R(1, 2) * R(1, 2)), c2 = R(2, 2);
  const bool free = std::abs(s2) < kSingularSine;
  const double s1 = free ? std::sin(seed) : R(1, 2) / s2;
  const double c1 = free ? std::cos(seed) : R(0, 2) / s2;
  // First column of (Rz(first) Ry(middle))^T R.
  const double x = c2 * (c1 * R(0, 0) + s1 * R(1, 0)) - s2 * R(2, 0);
  const double y = c1 * R(1, 0) - s1 * R(0, 0);
  return {free ? seed : std::atan2(s1, c1), std::atan2(s2, c2), std::atan2(y, x)};
}

}  // namespace aprsim::robot
