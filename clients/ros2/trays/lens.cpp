#include "clients/ros2/trays/lens.hpp"

namespace aprsim::ros2 {

Eigen::Isometry3d isometry_of(const v1::Pose& pose) {
  const auto& p = pose.position_m();
  const auto& q = pose.orientation();
  return Eigen::Translation3d(p.x(), p.y(), p.z()) *
         Eigen::Quaterniond(q.w(), q.x(), q.y(), q.z()).normalized();
}

std::optional<Eigen::Vector2d> pixel_of(const v1::CameraDescription& camera,
                                        const Eigen::Vector3d& in_camera) {
  if (in_camera.z() <= 0) return std::nullopt;
  const double x = in_camera.x() / in_camera.z(), y = in_camera.y() / in_camera.z();
  const auto term = [&](int i) {
    return i < camera.distortion_size() ? camera.distortion(i) : 0.0;
  };
  const double k1 = term(0), k2 = term(1), p1 = term(2), p2 = term(3), k3 = term(4);
  const double r2 = x * x + y * y;
  // Beyond the greatest distorted radius the polynomial comes back into the picture.
  if (1 + r2 * (3 * k1 + r2 * (5 * k2 + r2 * 7 * k3)) <= 0) return std::nullopt;
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double distorted_x = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
  const double distorted_y = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
  return Eigen::Vector2d(camera.focal_x_px() * distorted_x + camera.centre_x_px(),
                         camera.focal_y_px() * distorted_y + camera.centre_y_px());
}

}  // namespace aprsim::ros2
