#pragma once

#include <span>

namespace aprsim::physics {

struct PhysicsModel;
class PhysicsStep;

/// A world of another scene with the same robots, tools and surroundings goes on where `old` is:
/// `old_of` tells which of its bodies each one of `model` is, -1 = a new one, which stays where the
/// scene has it. All that rested wakes, and contacts are found anew: not bit for bit what would
/// have been, but the same whenever it is done.
void adopt(PhysicsModel& model, PhysicsStep& step, const PhysicsModel& old,
           const PhysicsStep& old_step, std::span<const int> old_of);

}  // namespace aprsim::physics
