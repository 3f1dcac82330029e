#pragma once

#include <memory>

#include "world/api/commands/command.hpp"
#include "world/base/result.hpp"
#include "world/cell/world_state.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::world {

/// Reads the scene that a reset names or carries as text, and checks it like a scene file.
/// Precondition: the reset has one of both. `present`: the scene of the start, whose files a text
/// may name, and whose step stays. Errors: the cause for which the scene cannot be used. Thread:
/// any.
[[nodiscard]] Result<std::shared_ptr<const api::NextScene>> read_next_scene(
    const api::Reset& reset, const scene::Scene& present);

/// Reads the scene of a command that resets to another one, and keeps it there. Other commands
/// are left as they are. Errors: as of read_next_scene(). Thread: any.
[[nodiscard]] Result<void> add_next_scene(api::Command& command, const scene::Scene& present);

/// The scene that read_next_scene() has read, and the models of its robots.
[[nodiscard]] std::shared_ptr<const scene::Scene> scene_of(const api::NextScene& next);
[[nodiscard]] const ArmModels& models_of(const api::NextScene& next);

}  // namespace aprsim::world
