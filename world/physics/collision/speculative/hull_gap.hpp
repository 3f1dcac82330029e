#pragma once

#include <Eigen/Geometry>

#include "world/physics/collision/shapes/gear_shape.hpp"

/// Lower bound of the distance of two bodies by their hulls: a cylinder about a gear, a box about
/// anything else. It is the largest separation along a few axes (separating axes).
namespace aprsim::physics {

struct HullGap {
  double m = -1e30;  ///< lower bound of the distance; <= 0 if they may touch
  Eigen::Vector3d n_W =
      Eigen::Vector3d::UnitZ();  ///< axis of that separation, from the second into the first
};

/// Axes: those of both gears, and the line between their middles.
[[nodiscard]] HullGap gear_gear_gap(const detail::GearShape& gear_a, const Eigen::Isometry3d& X_WA,
                                    const detail::GearShape& gear_b, const Eigen::Isometry3d& X_WB);

/// Axes: that of the gear and those of the box.
[[nodiscard]] HullGap gear_box_gap(const detail::GearShape& gear, const Eigen::Isometry3d& X_WG,
                                   const Eigen::Vector3d& size, const Eigen::Isometry3d& X_WS);

/// Axes: those of both boxes.
[[nodiscard]] HullGap box_box_gap(const Eigen::Vector3d& size_a, const Eigen::Isometry3d& X_WA,
                                  const Eigen::Vector3d& size_b, const Eigen::Isometry3d& X_WB);

}  // namespace aprsim::physics
