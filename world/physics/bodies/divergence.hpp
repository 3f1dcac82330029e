#pragma once

#include "world/physics/bodies/free_body.hpp"
#include "world/physics/bodies/rigid_body.hpp"

namespace aprsim::physics {

/// Whether a motion is not a number, or faster than anything that can happen in the cell: the
/// solution has diverged.
[[nodiscard]] bool has_diverged(const FreeBody& body);
[[nodiscard]] bool has_diverged(const BodyMotion& motion);

}  // namespace aprsim::physics
