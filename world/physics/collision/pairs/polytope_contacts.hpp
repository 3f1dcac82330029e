#pragma once

#include <Eigen/Geometry>

#include "world/physics/collision/reduction/contact_reduction.hpp"
#include "world/physics/collision/shapes/polytope.hpp"

namespace aprsim::physics::detail {

/// Contacts of two convex polyhedra: the face of one clipped by the face of the other, or where two
/// edges cross. Candidates are in b's frame with the normal into a. Exact to rounding. Internal
/// faces separate, but nothing leaves through them.
void polytope_on_polytope(const Polytope& a, const Eigen::Isometry3d& X_BA, const Polytope& b,
                          Candidates& out);

}  // namespace aprsim::physics::detail
