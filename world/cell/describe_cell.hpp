#pragma once

#include "world/api/description/cell_description.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::world {

/// Describes a scene's belt, light curtain, trays, gears and tools for clients. Bodies are numbered
/// as in the physics: trays first, then gears. Robots and fixed bodies stay empty: they describe
/// themselves. For publication only; a world behaves by its CellSettings.
[[nodiscard]] api::CellDescription describe_cell(const scene::Scene& scene);

}  // namespace aprsim::world
