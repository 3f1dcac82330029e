#pragma once

#include <cstdint>

#include "world/physics/model/physics_model.hpp"

namespace aprsim::physics {

/// FNV-1a over the bits of the poses and velocities of all free bodies and gripper parts.
[[nodiscard]] std::uint64_t state_hash(const PhysicsModel& model);

}  // namespace aprsim::physics
