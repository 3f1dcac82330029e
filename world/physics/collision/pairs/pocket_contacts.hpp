#pragma once

#include <Eigen/Geometry>

#include "world/physics/collision/pairs/capsule_contacts.hpp"
#include "world/physics/collision/reduction/contact_reduction.hpp"
#include "world/physics/collision/shapes/polytope.hpp"
#include "world/physics/collision/shapes/prism.hpp"
#include "world/scene/model/parts.hpp"

namespace aprsim::physics::detail {

/// Contacts of a convex polyhedron with a tray, in the tray's frame, normals into the polyhedron.
/// Corners and edges meet the walls and floors of pockets, faces meet the edge of their mouths: as
/// walls are concave and mouths convex, these are all features that can touch. Depths are exact for
/// features on surfaces and for edges across a mouth. True if a pocket with an outline is near.
bool polytope_on_pocketed_slab(const Polytope& polytope, const Eigen::Isometry3d& X_PS,
                               const Prism& slab, const scene::TrayType& tray, Candidates& out);

/// The same for a capsule: its ends meet walls and floors, and all of it the mouths.
bool capsule_on_pocketed_slab(const Segment& segment, double radius_m, const Prism& slab,
                              const scene::TrayType& tray, Candidates& out);

}  // namespace aprsim::physics::detail
