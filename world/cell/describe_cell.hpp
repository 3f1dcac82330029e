#pragma once

#include "world/api/description/cell_description.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::world {

[[nodiscard]] api::GripperDescription describe_gripper(const scene::Gripper& gripper);

/// What clients are told of a scene's belt, light curtain, trays, gears and tools; bodies are
/// numbered as in the physics: trays first, then gears. What robots and physics know of themselves
/// (robots, fixed) is left empty.
[[nodiscard]] api::CellDescription describe_cell(const scene::Scene& scene);

}  // namespace aprsim::world
