#pragma once

#include <Eigen/Geometry>

#include "world/physics/collision/pairs/circle_maxima.hpp"
#include "world/physics/collision/reduction/contact_reduction.hpp"
#include "world/physics/collision/shapes/gear_shape.hpp"

namespace aprsim::physics::detail {

/// Surface of a piece through which a point leaves it.
enum ExitFace : int { kThroughSide = 0, kThroughLow = 1, kThroughHigh = 2, kOutside = 3 };

/// Nearest exit of a piece for a point at radius r and height z (gear frame): through its side
/// or through the end faces of the convex whole it belongs to. Outside its height: how far,
/// negative.
[[nodiscard]] PenetrationExit penetration_exit(const Piece& piece, double r, double z);
/// The same for a point of a circle (gear frame).
[[nodiscard]] ExitWithGradient penetration_exit_along(const Piece& piece, const CirclePoint& at);

/// Adds the contact of a point q (gear frame) of another body's edge, running along d there (unit),
/// which lies inside the piece: out through the side or the nearer end face, or, where both are
/// about as near, at right angles to the edge and the piece's rim. Normal into the gear, in S.
void add_edge_point(const Piece& piece, const Eigen::Vector3d& q, const Eigen::Vector3d& d,
                    const Eigen::Isometry3d& X_SG, Candidates& out);

/// Adds the point with its exit through the side, at any height of the piece.
void add_side_point(const Piece& piece, const Eigen::Vector3d& q, const Eigen::Isometry3d& X_SG,
                    Candidates& out);

/// Points under the rim of an end face, where an edge passes over it, count up to this multiple of
/// the edge's longest exit of the piece.
inline constexpr double kEndShare = 1.5;

}  // namespace aprsim::physics::detail
