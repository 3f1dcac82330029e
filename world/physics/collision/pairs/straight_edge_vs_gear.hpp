#pragma once

#include <optional>
#include <span>

#include <Eigen/Geometry>

#include "world/physics/collision/reduction/contact_reduction.hpp"
#include "world/physics/collision/shapes/gear_shape.hpp"

namespace aprsim::physics::detail {

/// Straight convex edge from a to b between two faces with outward normals m0 and m1, in S; the
/// faces it runs into at its ends have the normals m_a and m_b.
struct StraightEdge {
  Eigen::Vector3d a, b, m0, m1, m_a, m_b;
};

/// Contacts of the edges with one piece of the gear.
struct PieceContacts {
  bool held = false;  ///< by a contact with a certain normal
  /// Alternative contact through the side, for an edge under the end face; the shallowest one.
  std::optional<Candidate> beside;
};

/// Contacts of the edge, corners included, with the gear: deepest behind the sides of its pieces,
/// and the ends of what lies under an exposed end face. Normals into the gear, in S. Those that do
/// not point out between the faces there go to `doubtful`: one of the faces holds the gear there,
/// or else the piece's side does.
void edge_on_gear(const GearShape& gear, const Eigen::Isometry3d& X_SG, const StraightEdge& edge,
                  std::span<PieceContacts> pieces, Candidates& out, Candidates& doubtful);

}  // namespace aprsim::physics::detail
