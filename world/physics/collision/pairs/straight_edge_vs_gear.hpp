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

/// What is known of a piece of the gear.
struct PieceFinds {
  bool held = false;  ///< something holds it
  /// Where an edge would hold it that lies under its end face: by its side. Of several the one with
  /// the shortest way out.
  std::optional<Candidate> beside;
};

/// Contacts of the edge, corners included, with the gear: deepest behind the sides of its pieces,
/// and the ends of what lies under an exposed end face. Normals into the gear, in S. Those that do
/// not point out between the faces there go to `doubtful`: one of the faces holds the gear there,
/// or else the piece's side does.
void edge_on_gear(const GearShape& gear, const Eigen::Isometry3d& X_SG, const StraightEdge& edge,
                  std::span<PieceFinds> pieces, Candidates& out, Candidates& doubtful);

}  // namespace aprsim::physics::detail
