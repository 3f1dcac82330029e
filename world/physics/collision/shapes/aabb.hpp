#pragma once

#include <Eigen/Geometry>

namespace aprsim::physics {

/// Axis-aligned bounding box in world [m].
struct Aabb {
  Eigen::Vector3d min = Eigen::Vector3d::Zero(), max = Eigen::Vector3d::Zero();

  [[nodiscard]] bool meets(const Aabb& other) const {
    return (min.array() <= other.max.array()).all() && (other.min.array() <= max.array()).all();
  }
  [[nodiscard]] Aabb grown(double by) const { return {min.array() - by, max.array() + by}; }
  [[nodiscard]] Aabb joined(const Aabb& other) const {
    return {min.cwiseMin(other.min), max.cwiseMax(other.max)};
  }
  [[nodiscard]] Aabb moved(const Eigen::Vector3d& by) const { return {min + by, max + by}; }

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [min, max] = self;
    io(min, max);
  }
};

/// Bounds of a box of edge lengths `size` centred at X_WS.
[[nodiscard]] inline Aabb aabb_of_box(const Eigen::Vector3d& size, const Eigen::Isometry3d& X_WS) {
  const Eigen::Vector3d reach = X_WS.linear().cwiseAbs() * (0.5 * size);
  return {X_WS.translation() - reach, X_WS.translation() + reach};
}

}  // namespace aprsim::physics
