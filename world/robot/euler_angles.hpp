#pragma once

#include <cmath>

#include <Eigen/Geometry>

/// Closed-form splits of a rotation into three turns about two axes; the last turn is taken from
/// what is left of the rotation, so the product is exact also close to the singular middle angle.
namespace aprsim::robot {

inline constexpr double kSingularSine = 1e-10;  ///< of the middle angle; below, `seed` decides

struct EulerAngles {
  double first = 0, middle = 0, last = 0;
};

[[nodiscard]] inline Eigen::Matrix3d rotation_about(const Eigen::Vector3d& axis, double angle) {
  return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
}

/// R = Rx(first) Ry(middle) Rx(last), the middle angle having the sign of `side`. Where it is 0 or
/// pi the first angle is free and becomes `seed`.
[[nodiscard]] inline EulerAngles split_xyx(const Eigen::Matrix3d& R, double side, double seed) {
  const double sine = std::hypot(R(1, 0), R(2, 0));
  EulerAngles out;
  out.first = sine < kSingularSine ? seed : std::atan2(side * R(1, 0), -side * R(2, 0));
  out.middle = std::atan2(side * sine, R(0, 0));
  const Eigen::Matrix3d front = rotation_about(Eigen::Vector3d::UnitX(), out.first) *
                                rotation_about(Eigen::Vector3d::UnitY(), out.middle);
  const Eigen::Vector3d rest = front.transpose() * R.col(1);
  out.last = std::atan2(rest.z(), rest.y());
  return out;
}

/// R = Rz(first) Ry(middle) Rz(last); see split_xyx().
[[nodiscard]] inline EulerAngles split_zyz(const Eigen::Matrix3d& R, double side, double seed) {
  const double sine = std::hypot(R(0, 2), R(1, 2));
  EulerAngles out;
  out.first = sine < kSingularSine ? seed : std::atan2(side * R(1, 2), side * R(0, 2));
  out.middle = std::atan2(side * sine, R(2, 2));
  const Eigen::Matrix3d front = rotation_about(Eigen::Vector3d::UnitZ(), out.first) *
                                rotation_about(Eigen::Vector3d::UnitY(), out.middle);
  const Eigen::Vector3d rest = front.transpose() * R.col(0);
  out.last = std::atan2(rest.y(), rest.x());
  return out;
}

}  // namespace aprsim::robot
