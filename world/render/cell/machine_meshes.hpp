#pragma once

#include "world/api/description/cell_description.hpp"
#include "world/render/mesh/mesh.hpp"
#include "world/robot/model/arm_model.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::render {

/// A link by its visual shapes; by its collision shapes where it has none.
[[nodiscard]] Mesh link_mesh(const robot::Link& link);

/// A tool without its fingers, in its frame T.
[[nodiscard]] Mesh tool_mesh(const api::ToolDescription& tool);
/// The finger at +y with its pad's face at y = 0. The other one is it turned by half about z.
[[nodiscard]] Mesh finger_mesh(const api::ToolDescription& tool);

/// A fixed box in the frame of its centre. `above_floor_m`: height of its underside, for its legs.
[[nodiscard]] Mesh fixed_mesh(const scene::StaticBox& box, double above_floor_m);
/// The belt's moving top face, then its frame; in the frame of the belt.
[[nodiscard]] Mesh belt_mesh(const scene::Conveyor& conveyor);
[[nodiscard]] Mesh belt_frame_mesh(const scene::Conveyor& conveyor);
[[nodiscard]] Mesh floor_mesh();
[[nodiscard]] Mesh intruder_mesh();  ///< a box of 1 m

}  // namespace aprsim::render
