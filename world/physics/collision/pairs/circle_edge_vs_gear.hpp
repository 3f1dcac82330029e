#pragma once

#include <Eigen/Geometry>

#include "world/physics/collision/reduction/contact_reduction.hpp"
#include "world/physics/collision/shapes/gear_shape.hpp"

namespace aprsim::physics::detail {

/// A circle on another body, in the gear's frame.
struct Circle {
  Eigen::Vector3d c = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  double r = 0;
};

/// Contacts of a convex circular edge (a pocket's mouth, another gear's rim) with the gear: where
/// it lies deepest behind the side of a piece, and where it passes over the rim of an exposed end
/// face. A circle that lies just under an end face leaves through that face only. Candidates are in
/// S with the normal into the gear.
void circle_on_piece(const Piece& piece, const Eigen::Isometry3d& X_SG, const Circle& circle,
                     Candidates& out);
void circle_on_gear(const GearShape& gear, const Eigen::Isometry3d& X_SG, const Circle& circle,
                    Candidates& out);

}  // namespace aprsim::physics::detail
