#pragma once

#include <Eigen/Geometry>

#include "world/physics/collision/reduction/contact_reduction.hpp"
#include "world/physics/collision/shapes/gear_shape.hpp"

namespace aprsim::physics::detail {

/// The point where the sides of two frusta cross, if it lies within both: the middle of two
/// generators with opposite normals. In b's frame, normal into a. Exact.
void crossing_cones(const Piece& a, const Eigen::Isometry3d& X_BA, const Piece& b, Candidates& out);

}  // namespace aprsim::physics::detail
