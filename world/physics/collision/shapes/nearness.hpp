#pragma once

#include <Eigen/Geometry>

#include "world/physics/collision/shapes/gear_shape.hpp"
#include "world/physics/collision/shapes/polytope.hpp"
#include "world/physics/collision/shapes/prism.hpp"

/// Signed distances of points to convex shapes, exact, each in the shape's frame. They are convex
/// functions of the point.
namespace aprsim::physics::detail {

struct Nearness {
  double distance = 0;                             ///< negative inside
  Eigen::Vector3d out = Eigen::Vector3d::UnitZ();  ///< its gradient, unit: away from the shape
};

[[nodiscard]] Nearness nearness(const Prism& prism, const Eigen::Vector3d& p);
/// A box about the origin.
[[nodiscard]] Nearness nearness(const Eigen::Vector3d& size, const Eigen::Vector3d& p);
/// One piece of a gear as a solid of its own.
[[nodiscard]] Nearness nearness(const Piece& piece, const Eigen::Vector3d& p);
[[nodiscard]] Nearness nearness(const Polytope& polytope, const Eigen::Vector3d& p);
/// All within a radius of the segment from -half_length to half_length on z.
[[nodiscard]] Nearness capsule_nearness(double radius_m, double half_length_m,
                                        const Eigen::Vector3d& p);

}  // namespace aprsim::physics::detail
