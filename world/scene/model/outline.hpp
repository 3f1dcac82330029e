#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

namespace aprsim::scene {

/// A convex polygon in the plane z = 0, counter-clockwise seen from above [m].
struct Outline {
  static constexpr std::size_t kMaxCorners = 24;
  std::vector<Eigen::Vector2d> corners;
  std::vector<Eigen::Vector2d> normals;  ///< outward, of the side from corner i to corner i + 1

  /// Distance of a point from the nearest side's line, positive inside.
  [[nodiscard]] double depth_of(const Eigen::Vector2d& p) const {
    double depth = 1e30;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      depth = std::min(depth, normals[i].dot(corners[i] - p));
    }
    return depth;
  }
};

/// The outline with these corners, which must be convex and counter-clockwise.
[[nodiscard]] inline Outline outline_of(std::vector<Eigen::Vector2d> corners) {
  Outline outline;
  outline.corners = std::move(corners);
  for (std::size_t i = 0; i < outline.corners.size(); ++i) {
    const Eigen::Vector2d side =
        outline.corners[(i + 1) % outline.corners.size()] - outline.corners[i];
    outline.normals.push_back(Eigen::Vector2d(side.y(), -side.x()).normalized());
  }
  return outline;
}

/// The outline turned by `yaw_rad` about its origin, which comes to `xy`.
[[nodiscard]] inline Outline placed(const Outline& outline, const Eigen::Vector2d& xy,
                                    double yaw_rad) {
  const Eigen::Rotation2Dd turn(yaw_rad);
  Outline out;
  for (const Eigen::Vector2d& corner : outline.corners) out.corners.push_back(xy + turn * corner);
  for (const Eigen::Vector2d& normal : outline.normals) out.normals.push_back(turn * normal);
  return out;
}

/// The outline with each side moved outwards by `by_m`.
[[nodiscard]] inline Outline widened(const Outline& outline, double by_m) {
  Outline out = outline;
  const std::size_t n = outline.corners.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector2d &a = outline.normals[(i + n - 1) % n], &b = outline.normals[i];
    out.corners[i] += by_m / (1 + a.dot(b)) * (a + b);
  }
  return out;
}

}  // namespace aprsim::scene
