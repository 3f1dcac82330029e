#pragma once

#include "world/physics/collision/shapes/pocket_outline.hpp"
#include "world/physics/collision/shapes/polytope.hpp"
#include "world/physics/collision/shapes/prism.hpp"

/// The material around a pocket with an outline as convex pieces, for bodies without corners. The
/// faces between pieces are internal.
namespace aprsim::physics::detail {

/// Becomes the material behind side i, some millimetres of it: its wall, chamfer and a strip of the
/// top face are exposed. `underside`: z of the slab's.
void set_wall_piece(const PocketOutline& pocket, std::size_t side, double underside,
                    Polytope& piece);

/// The material under the floor, with the floor as its top. It reaches a little under the walls, so
/// that a point behind a wall is still held by the floor.
void set_floor_piece(const PocketOutline& pocket, double underside, Prism& piece);

}  // namespace aprsim::physics::detail
