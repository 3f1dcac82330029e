#pragma once

#include <span>

#include <Eigen/Geometry>

#include "world/physics/collision/reduction/contact_reduction.hpp"
#include "world/physics/collision/shapes/gear_shape.hpp"
#include "world/physics/collision/shapes/pocket.hpp"
#include "world/physics/collision/shapes/polytope.hpp"
#include "world/physics/collision/shapes/prism.hpp"

namespace aprsim::physics::detail {

/// Contacts of a gear with a prism whose top face (z1 = 0) may have pockets: the gear's rims on the
/// faces and in the pockets, the prism's straight edges and corners on the gear. In the prism's
/// frame S; normals into the gear. False when their bounds are apart (then nothing was added).
bool gear_on_prism(const GearShape& gear, const Eigen::Isometry3d& X_SG, const Prism& prism,
                   std::span<const PocketProfile> pockets, Candidates& out);

/// The same with a convex polyhedron, in its frame.
bool gear_on_polytope(const GearShape& gear, const Eigen::Isometry3d& X_SG,
                      const Polytope& polytope, Candidates& out);

}  // namespace aprsim::physics::detail
