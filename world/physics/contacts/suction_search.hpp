#pragma once

#include "world/physics/model/physics_model.hpp"

/// Suction of vacuum cups: gaps under their lips, vacuum, and its forces on part and palm. Nothing
/// is attached: a part is held against the lip by contact and friction under the suction's force.
namespace aprsim::physics {

/// Once a step, after contact search: updates seal and vacuum of each cup.
void find_suction(PhysicsModel& model);

/// Before each solve of the step: loads bodies and palms with the suction forces.
void apply_suction(PhysicsModel& model);

}  // namespace aprsim::physics
