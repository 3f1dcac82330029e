#pragma once

#include <cstdint>

#include "world/physics/model/physics_model.hpp"

namespace aprsim::physics {

/// Throws PhysicsFailure if a body's state is not a number or its speed is impossible in the cell:
/// such a state would spread to other bodies in a later step.
void check_state(const PhysicsModel& model, std::uint64_t step);

}  // namespace aprsim::physics
