#pragma once

#include "world/physics/bodies/rigid_body.hpp"

namespace aprsim::physics {

/// Whether a motion is not a number, or faster than anything that can happen in the cell: the
/// solution has diverged. `radius_m`: of a sphere about the centre of mass that holds the body.
[[nodiscard]] bool has_diverged(const BodyMotion& motion, double radius_m);

}  // namespace aprsim::physics
