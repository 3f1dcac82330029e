#pragma once

#include <variant>
#include <vector>

#include <Eigen/Geometry>

#include "world/scene/model/parts.hpp"

/// How deep two convex solids lie in each other; for checking a scene, not for contacts.
namespace aprsim::scene {

struct BoxSolid {
  Eigen::Vector3d half_size;
};
/// Frustum about z, centred half-way up.
struct FrustumSolid {
  double half_height = 0, radius_bottom = 0, radius_top = 0;
};
/// Convex prism along z, centred half-way up.
struct PrismSolid {
  Outline outline;
  double half_height = 0;
};
/// Capsule about z, centred half-way up; a sphere where it has no length.
struct CapsuleSolid {
  double radius = 0, half_length = 0;
};
/// Convex polyhedron about the frame's origin.
struct HullSolid {
  std::vector<Eigen::Vector3d> corners, normals;
};
struct Solid {
  std::variant<BoxSolid, FrustumSolid, PrismSolid, CapsuleSolid, HullSolid> shape;
  Eigen::Isometry3d X_WS = Eigen::Isometry3d::Identity();  ///< centre in world

  /// The point furthest along `d_W`.
  [[nodiscard]] Eigen::Vector3d support(const Eigen::Vector3d& d_W) const;
  /// Radius of a sphere about the centre that holds the solid.
  [[nodiscard]] double bounding_radius() const;
};

/// Smallest travel [m] that parts the solids; <= 0 when they are apart. The depth is exact for
/// boxes and for upright solids, an upper bound for tilted round ones.
[[nodiscard]] double overlap_depth(const Solid& a, const Solid& b);

/// How far the solid reaches below the plane z = 0 [m]; <= 0 when it does not.
[[nodiscard]] double depth_below_ground(const Solid& solid);

}  // namespace aprsim::scene
