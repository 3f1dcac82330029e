#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "world/physics/collision/shapes/contact.hpp"
#include "world/physics/collision/shapes/convex_piece.hpp"
#include "world/scene/model/parts.hpp"

/// Contacts of convex shapes of every kind, and of these with trays. As narrow_phase.hpp: one pair
/// a call, the normal points from b into a, contacts are made only when depth > 0, and no call
/// allocates once `out` and the thread's work space have their sizes. Pairs that have an exact
/// method of their own use it: round on round, round on box or prism, box on box. Depths are exact
/// to rounding, of capsules to 1e-12 m; the ends of a capsule's line contact to 1e-5 m along it.
namespace aprsim::physics {

/// The two bodies of contacts and their surfaces.
struct ContactSides {
  BodyIndex a = kGround, b = kGround;
  SurfacePair pair = SurfacePair::kPart;
};

void shape_on_shape(const ConvexShape& a, const Eigen::Isometry3d& X_WA, const ConvexShape& b,
                    const Eigen::Isometry3d& X_WB, const ContactSides& sides,
                    std::vector<Contact>& out);

/// A shape on or in a tray. In a pocket, corners and edges of polyhedra and ends of capsules meet
/// wall and floor, and its mouth meets faces and edges.
void shape_on_tray(const ConvexShape& shape, const Eigen::Isometry3d& X_WS,
                   const scene::TrayType& tray, const Eigen::Isometry3d& X_WP,
                   const ContactSides& sides, std::vector<Contact>& out);

/// Joins the contacts from `first` on that several pieces of one body have in one plane: at most
/// eight of them stay.
void reduce_planes(std::size_t first, std::vector<Contact>& out);

}  // namespace aprsim::physics
