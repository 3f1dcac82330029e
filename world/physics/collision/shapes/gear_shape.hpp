#pragma once

#include <algorithm>
#include <array>

#include <Eigen/Core>

#include "world/scene/model/scene.hpp"

/// A gear as convex pieces of revolution and the circles that bound their faces. Internal to
/// contact generation.
namespace aprsim::physics::detail {

/// A piece that overlaps the other body by less than this along one face's normal rests on that
/// face; its points near other faces then do not count. [m]
inline constexpr double kResting = 1e-4;

/// How far a side is taken into the wider piece it is glued to: an edge that has sunk a little into
/// the neighbour's face still meets the side in the corner. [m]
inline constexpr double kGluedReach = 1e-3;

/// Frustum about the gear's z axis. An end that is glued to another piece is not exposed: nothing
/// can touch it.
struct Piece {
  double z0 = 0, r0 = 0, z1 = 0, r1 = 0;
  bool low_exposed = false, high_exposed = false;
  double z_out_low = -1e30, z_out_high = 1e30;  ///< end faces through which one may leave
  double low_reach = 0, high_reach = 0;         ///< into a wider neighbour
  double slope = 0;                             ///< dr/dz
  double cosine = 1;                            ///< of the angle between the side and the axis

  /// May one leave through an end face, its own or that of a piece below or above?
  [[nodiscard]] bool opens_low() const { return z_out_low > -1e29; }
  [[nodiscard]] bool opens_high() const { return z_out_high < 1e29; }
  [[nodiscard]] double radius(double z) const { return r0 + slope * (z - z0); }
  /// Distance from height z to the nearer of the faces through which one may leave.
  [[nodiscard]] double to_end(double z) const { return std::min(z - z_out_low, z_out_high - z); }
};

/// A circular edge of the gear.
struct Ring {
  double z = 0, r = 0;
  int piece = 0;  ///< index of the piece whose rim it is
};

struct GearShape {
  GearShape() = default;
  /// The same gear, taken apart; also where one is wanted.
  GearShape(const scene::GearType& gear);

  std::array<Piece, 4> pieces;  ///< disc, hub, hub chamfer, peg; those that exist
  std::array<Ring, 5> rings;
  int piece_count = 0, ring_count = 0;
  double z_low = 0, z_high = 0, r_max = 0;  ///< bounding cylinder
  double r_peg = 0;                         ///< 0 = none

  [[nodiscard]] Eigen::Vector3d middle() const { return {0, 0, 0.5 * (z_low + z_high)}; }
};

/// A single frustum: a radius at each of two heights, both above 0.
[[nodiscard]] GearShape frustum_shape(double z_low, double r_low, double z_high, double r_high);

}  // namespace aprsim::physics::detail
