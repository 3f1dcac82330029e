#pragma once

#include <memory>

#include "world/api/commands/command.hpp"
#include "world/base/result.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::world {

/// Of a reset to another scene: reads it, checks it as a file is, and puts it into the command;
/// nothing for all else. The listeners belong to robots: the scene must have those of `present`,
/// with the same models and names, in the same order. Errors: what is wrong with the scene.
/// Thread: any.
[[nodiscard]] Result<void> read_next_scene(api::Command& command, const scene::Scene& present);

/// The scene of what read_next_scene() has made.
[[nodiscard]] std::shared_ptr<const scene::Scene> scene_of(const api::NextScene& next);

}  // namespace aprsim::world
