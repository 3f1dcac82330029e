#pragma once

#include <Eigen/Geometry>

#include "world/physics/collision/shapes/gear_shape.hpp"

/// How bodies lie to each other by their hulls, the cylinder about a gear and the box about all
/// else: along which axis they are farthest apart, or overlap least (separating axes).
namespace aprsim::physics {

struct HullGap {
  double m = -1e30;  ///< lower bound of the distance; not above 0 where they may touch
  Eigen::Vector3d n_W = Eigen::Vector3d::UnitZ();  ///< that axis, from the second into the first
};

/// Along both axes, and along the line between their middles.
[[nodiscard]] HullGap gear_gear_gap(const detail::GearShape& gear_a, const Eigen::Isometry3d& X_WA,
                                    const detail::GearShape& gear_b, const Eigen::Isometry3d& X_WB);

/// Along the gear's axis and the box's.
[[nodiscard]] HullGap gear_box_gap(const detail::GearShape& gear, const Eigen::Isometry3d& X_WG,
                                   const Eigen::Vector3d& size, const Eigen::Isometry3d& X_WS);

/// Along the axes of both.
[[nodiscard]] HullGap box_box_gap(const Eigen::Vector3d& size_a, const Eigen::Isometry3d& X_WA,
                                  const Eigen::Vector3d& size_b, const Eigen::Isometry3d& X_WB);

}  // namespace aprsim::physics
