#pragma once

#include <array>
#include <variant>
#include <vector>

#include "world/api/values/pose.hpp"

/// Convex pieces that parts and fixtures consist of. Each is centred on its frame, except a hull.
/// SI.
namespace aprsim::api {

struct BoxPiece {
  Eigen::Vector3d size = Eigen::Vector3d::Zero();  ///< edge lengths
};

/// A frustum about z; a cylinder where both radii are the same.
struct ConePiece {
  double bottom_radius_m = 0, top_radius_m = 0, height_m = 0;
};

/// All points within a radius of a segment along z; a sphere where that has no length.
struct CapsulePiece {
  double radius_m = 0;
  double length_m = 0;  ///< of the segment
};

/// A convex polygon in the plane z = 0, extended along z.
struct PrismPiece {
  std::vector<Eigen::Vector2d> corners;  ///< counter-clockwise, seen from above
  double height_m = 0;
};

/// A convex polyhedron.
struct HullPiece {
  std::vector<Eigen::Vector3d> corners;
  /// Indices of each face's corners, counter-clockwise, seen from outside.
  std::vector<std::vector<int>> faces;
};

struct Piece {
  std::variant<BoxPiece, ConePiece, CapsulePiece, PrismPiece, HullPiece> shape;
  Pose X_BP;  ///< frame of the piece in that of the part or fixture
};

}  // namespace aprsim::api
