#pragma once

#include <Eigen/Geometry>

#include "world/physics/collision/gear_shape.hpp"

/// Lower bounds of the distance between two bodies [m], by the cylinder about a gear and the box
/// about all else (separating axes). Bodies that may touch have none above 0.
namespace aprsim::physics {

[[nodiscard]] double gear_gear_gap(const detail::GearShape& gear_a, const Eigen::Isometry3d& X_WA,
                                   const detail::GearShape& gear_b, const Eigen::Isometry3d& X_WB);

/// Along the box's axes and the gear's.
[[nodiscard]] double gear_box_gap(const detail::GearShape& gear, const Eigen::Isometry3d& X_WG,
                                  const Eigen::Vector3d& size, const Eigen::Isometry3d& X_WS);

/// Along the axes of both.
[[nodiscard]] double box_box_gap(const Eigen::Vector3d& size_a, const Eigen::Isometry3d& X_WA,
                                 const Eigen::Vector3d& size_b, const Eigen::Isometry3d& X_WB);

}  // namespace aprsim::physics
