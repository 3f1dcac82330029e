#pragma once

#include <Eigen/Core>

#include "world/physics/collision/reduction/contact_reduction.hpp"
#include "world/physics/collision/shapes/pocket.hpp"
#include "world/physics/collision/shapes/prism.hpp"

namespace aprsim::physics::detail {

/// A rim of the gear in the tray's frame S: centre, axis, body-fixed radii.
struct RimS {
  Eigen::Vector3d c;
  double r = 0;
  const Eigen::Vector3d& u;
  const Eigen::Vector3d& e1;
  const Eigen::Vector3d& e2;
  double sine = 0;  ///< of the tilt against the tray
};

enum class RimInPocket {
  kApart,     ///< outside of the mouth or around it: cannot touch the sides
  kFree,      ///< wholly in the pocket's void
  kTouching,  ///< may touch
};

/// Corners: how far behind the wall a point may be and still be held by the floor. [m]
inline constexpr double kCornerReach = 0.5e-3;

[[nodiscard]] RimInPocket rim_in_pocket(const RimS& rim, const PocketProfile& pocket);

/// Contacts of the rim with wall, chamfer and the mouth's corner (deepest points around it), normal
/// out of the material. `slab`: around the pockets, with its top face at z = 0.
void rim_on_pocket_side(const RimS& rim, const PocketProfile& pocket, const Prism& slab,
                        Candidates& out);

/// Contacts of the rim with the floor: four points around it. `underside`: z of the slab's.
void rim_on_pocket_floor(const RimS& rim, const PocketProfile& pocket, double underside,
                         Candidates& out);

/// Two directions at right angles in the rim's plane, for four points against a plane with normal
/// n: body-fixed when the rim is parallel to the plane, turning to the deepest direction (d1) as it
/// tilts. `sine` is of the angle between n and the axis.
void anchor_directions(const RimS& rim, const Eigen::Vector3d& n, double sine, Eigen::Vector3d& d1,
                       Eigen::Vector3d& d2);

}  // namespace aprsim::physics::detail
