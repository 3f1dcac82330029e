#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "world/scene/model/scene.hpp"

namespace aprsim::physics::detail {

/// A pocket with an outline, in the tray frame: walls along a convex polygon, and above `z_edge` a
/// chamfer along each of them. z is measured from the tray's top face. Side i runs from corner i to
/// corner i + 1, and its normal points out of the void into the tray's material.
struct PocketOutline {
  static constexpr std::size_t kMost = scene::Outline::kMaxCorners;

  std::size_t sides = 0;
  std::array<Eigen::Vector2d, kMost> corners;  ///< of the walls
  std::array<Eigen::Vector2d, kMost> normals;  ///< of the walls
  std::array<double, kMost> off;               ///< n . p on the walls
  double depth = 0;
  double z_edge = 0;  ///< where walls and chamfers meet; 0 without chamfers
  double width = 0;   ///< of the chamfers, horizontally
  double chamfer_slope = 0, chamfer_cos = 1;
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  double radius = 0;  ///< of a circle about the middle around the mouth

  PocketOutline() = default;
  explicit PocketOutline(const scene::Slot& slot)
      : sides(slot.pocket.outline->corners.size()),
        depth(slot.pocket.depth_m),
        z_edge(-slot.pocket.chamfer_m) {
    if (chamfered()) {
      chamfer_slope = std::tan(slot.pocket.chamfer_angle_rad);
      chamfer_cos = std::cos(slot.pocket.chamfer_angle_rad);
      width = -chamfer_slope * z_edge;
    }
    const Eigen::Rotation2Dd turn(slot.yaw_rad);
    const scene::Outline& outline = *slot.pocket.outline;
    for (std::size_t i = 0; i < sides; ++i) {
      corners[i] = slot.xy + turn * outline.corners[i];
      normals[i] = turn * outline.normals[i];
      off[i] = normals[i].dot(corners[i]);
      middle += corners[i] / static_cast<double>(sides);
    }
    for (std::size_t i = 0; i < sides; ++i) {
      radius = std::max(radius, (corner(i, width) - middle).norm());
    }
  }

  [[nodiscard]] bool chamfered() const { return z_edge < 0; }
  [[nodiscard]] std::size_t next(std::size_t i) const { return i + 1 == sides ? 0 : i + 1; }
  [[nodiscard]] std::size_t last(std::size_t i) const { return i == 0 ? sides - 1 : i - 1; }
  /// Corner i of the outline with its sides moved outwards by `by`.
  [[nodiscard]] Eigen::Vector2d corner(std::size_t i, double by) const {
    const Eigen::Vector2d &a = normals[last(i)], &b = normals[i];
    return corners[i] + by / (1 + a.dot(b)) * (a + b);
  }
  [[nodiscard]] double beyond(std::size_t i, const Eigen::Vector3d& p) const {
    return normals[i].dot(p.head<2>()) - off[i];
  }
  /// How deep a point lies behind a wall and its chamfer: positive in the tray's material.
  [[nodiscard]] double behind_chamfer(std::size_t i, const Eigen::Vector3d& p) const {
    return (beyond(i, p) - width - chamfer_slope * p.z()) * chamfer_cos;
  }
  [[nodiscard]] double behind_side(std::size_t i, const Eigen::Vector3d& p) const {
    return chamfered() ? std::min(beyond(i, p), behind_chamfer(i, p)) : beyond(i, p);
  }
  /// The largest over all sides: negative in the void, where z is between floor and top face.
  [[nodiscard]] double behind(const Eigen::Vector3d& p) const {
    double most = -1e30;
    for (std::size_t i = 0; i < sides; ++i) most = std::max(most, behind_side(i, p));
    return most;
  }
  /// Whether a point under the top face is in the void, or the way into it is shorter than `exit`.
  [[nodiscard]] bool takes(const Eigen::Vector3d& p, double exit) const {
    const Eigen::Vector3d under_top(p.x(), p.y(), std::min(p.z(), 0.0));
    const double below = -depth - p.z(), side = behind(under_top);
    if (below < 0) return side < exit;
    return std::sqrt(below * below + std::pow(std::max(0.0, side), 2)) < exit;
  }
};

}  // namespace aprsim::physics::detail
