#pragma once

#include <array>
#include <cstddef>
#include <span>

#include <Eigen/Geometry>

#include "world/scene/model/scene.hpp"

namespace aprsim::physics::detail {

/// Convex prism along z: a counter-clockwise polygon from z0 to z1. Internal sides bound the prism
/// towards another part of the same body: nothing leaves through them.
struct Prism {
  static constexpr int kMaxSides = static_cast<int>(scene::Outline::kMaxCorners);
  int sides = 0;
  std::array<Eigen::Vector2d, kMaxSides> v;  ///< corners; side i runs from v[i] to v[i + 1]
  std::array<Eigen::Vector2d, kMaxSides> n;  ///< outward normals of the sides
  std::array<double, kMaxSides> off;         ///< of the sides' planes: n . p on them
  std::array<bool, kMaxSides> internal{};
  double z0 = 0, z1 = 0;
  Eigen::Vector3d middle;  ///< a point well inside

  [[nodiscard]] const Eigen::Vector2d& corner(int i) const {
    return v[static_cast<std::size_t>(i % sides)];
  }
  /// Sets the polygon; both lists have the same length, at most kMaxSides.
  void set_sides(std::span<const Eigen::Vector2d> corners,
                 std::span<const Eigen::Vector2d> normals);
};

[[nodiscard]] Prism box_prism(const Eigen::Vector3d& lo, const Eigen::Vector3d& hi);

/// The tray's slab without its pockets, in the tray frame.
[[nodiscard]] Prism slab_prism(const scene::TrayType& tray);

}  // namespace aprsim::physics::detail
