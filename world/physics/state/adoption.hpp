#pragma once

#include <span>

namespace aprsim::physics {

struct PhysicsModel;
class PhysicsStep;

/// Continues `old` in a world of another scene with the same robots, tools and surroundings.
/// `old_of` maps each body of `model` to one of `old`; -1 is a new body, which keeps the scene's
/// pose. All bodies wake and contacts are detected again. The result is reproducible, but differs
/// from that of the old world.
void adopt(PhysicsModel& model, PhysicsStep& step, const PhysicsModel& old,
           const PhysicsStep& old_step, std::span<const int> old_of);

}  // namespace aprsim::physics
