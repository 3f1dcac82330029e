#pragma once

#include <array>
#include <span>

#include <Eigen/Geometry>

#include "world/physics/collision/reduction/contact_reduction.hpp"
#include "world/physics/collision/shapes/gear_shape.hpp"
#include "world/physics/collision/shapes/pocket.hpp"

namespace aprsim::physics::detail {

/// Convex prism along z: a counter-clockwise polygon from z0 to z1. Internal sides bound the prism
/// towards another part of the same body: nothing leaves through them.
struct Prism {
  static constexpr int kMaxSides = 5;
  int sides = 0;
  std::array<Eigen::Vector2d, kMaxSides> v;  ///< corners; side i runs from v[i] to v[i + 1]
  std::array<Eigen::Vector2d, kMaxSides> n;  ///< outward normals of the sides
  std::array<bool, kMaxSides> internal{};
  double z0 = 0, z1 = 0;
  Eigen::Vector3d middle;  ///< a point well inside

  [[nodiscard]] const Eigen::Vector2d& corner(int i) const {
    return v[static_cast<std::size_t>(i % sides)];
  }
};

[[nodiscard]] Prism box_prism(const Eigen::Vector3d& lo, const Eigen::Vector3d& hi);

/// Contacts of a gear with a prism whose top face (z1 = 0) may have pockets: the gear's rims on the
/// faces and in the pockets, the prism's straight edges and corners on the gear. In the prism's
/// frame S; normals into the gear. False when their bounds are apart (then nothing was added).
bool gear_on_prism(const GearShape& gear, const Eigen::Isometry3d& X_SG, const Prism& prism,
                   std::span<const PocketProfile> pockets, Candidates& out);

}  // namespace aprsim::physics::detail
