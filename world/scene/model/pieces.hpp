#pragma once

#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "world/api/values/piece.hpp"
#include "world/scene/model/outline.hpp"

/// Geometry of convex pieces: bounds, volume and moments, hulls of points.
namespace aprsim::scene {

/// Farthest point of a piece along `d`, both in the piece's frame.
[[nodiscard]] Eigen::Vector3d support_of(const api::Piece& piece, const Eigen::Vector3d& d);

/// The box along the axes of the part's frame around all pieces.
[[nodiscard]] Eigen::AlignedBox3d bounds_of(std::span<const api::Piece> pieces);
/// The box along the axes of the piece's own frame.
[[nodiscard]] Eigen::AlignedBox3d own_bounds_of(const api::Piece& piece);

/// Volume, centre and inertia of the union for a density of 1 kg/m^3. A volume that pieces share
/// counts in each of them.
struct UnitMass {
  double volume_m3 = 0;
  Eigen::Vector3d com = Eigen::Vector3d::Zero();      ///< in the part's frame
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< about the com, axes of the part's frame
};
[[nodiscard]] UnitMass unit_mass_of(std::span<const api::Piece> pieces);

/// Most corners of a hull.
inline constexpr std::size_t kMaxHullCorners = 64;

/// The convex hull of at most kMaxHullCorners points, without those that are no corners. Without
/// faces if the points lie in a plane.
[[nodiscard]] api::HullPiece hull_of(std::span<const Eigen::Vector3d> points);

}  // namespace aprsim::scene
