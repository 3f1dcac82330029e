#pragma once

#include <Eigen/Geometry>

#include "world/physics/contact_candidates.hpp"
#include "world/physics/gear_shape.hpp"

namespace aprsim::physics::detail {

/// Contacts of a straight convex edge from a to b (in S), corners included, with the gear: deepest
/// behind the sides of its pieces, and the ends of what lies under an exposed end face. Normals
/// into the gear, in S.
void edge_on_gear(const GearShape& gear, const Eigen::Isometry3d& X_SG, const Eigen::Vector3d& a,
                  const Eigen::Vector3d& b, Candidates& out);

}  // namespace aprsim::physics::detail
