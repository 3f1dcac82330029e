#pragma once

#include <cstdint>

#include "world/physics/model/physics_model.hpp"

namespace aprsim::physics {

/// Throws PhysicsFailure when a body's state is not a number or its speed is beyond anything that
/// can happen in the cell; such a state would spread in a later step.
void check_state(const PhysicsModel& model, std::uint64_t step);

}  // namespace aprsim::physics
