#pragma once

#include "world/physics/model/physics_model.hpp"

/// Suction of vacuum cups: gaps under their lips, vacuum, and its forces on part and palm. Nothing
/// is attached: a part is held against the lip by contact and friction under the suction's force.
namespace aprsim::physics {

/// After the contacts of a step are known, once: how each lip lies, and the vacuum that follows.
void find_suction(PhysicsModel& model);

/// Before each solution of the step: loads bodies and palms with the suction's forces.
void apply_suction(PhysicsModel& model);

}  // namespace aprsim::physics
