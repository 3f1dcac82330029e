#pragma once

#include <limits>

#include <Eigen/Geometry>

#include "world/physics/collision/shapes/convex_piece.hpp"
#include "world/scene/model/scene.hpp"

/// Distances along a ray to the cell's shapes, from exact geometry; no ODE. No call allocates.
namespace aprsim::physics {

inline constexpr double kNoHit = std::numeric_limits<double>::infinity();

/// A half line: origin and unit direction in world.
struct Ray {
  Eigen::Vector3d p_W, d_W;
};

/// To the first surface that the ray enters [m], kNoHit when it misses; 0 from inside.
[[nodiscard]] double distance_to_gear(const scene::GearType& gear, const Eigen::Isometry3d& X_WG,
                                      const Ray& ray);
/// Pockets are holes down to their floors.
[[nodiscard]] double distance_to_tray(const scene::TrayType& tray, const Eigen::Isometry3d& X_WP,
                                      const Ray& ray);
[[nodiscard]] double distance_to_box(const Eigen::Vector3d& size, const Eigen::Isometry3d& X_WS,
                                     const Ray& ray);

/// `X_WP`: pose of the piece.
[[nodiscard]] double distance_to_piece(const ConvexPiece& piece, const Eigen::Isometry3d& X_WP,
                                       const Ray& ray);

}  // namespace aprsim::physics
