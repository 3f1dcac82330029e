#pragma once

#include <string>

#include "world/api/error.hpp"
#include "world/scene/data_paths.hpp"
#include "world/scene/scene.hpp"

namespace aprsim::scene {

/// Loads a scene by name or by file path (anything with a slash or ending in .yaml). Unknown key,
/// wrong type, missing file, bad reference, interpenetrating objects: an error whose field is the
/// key's path and whose message reads "FILE:LINE:COLUMN: KEY: found ..., expected ...".
[[nodiscard]] Result<Scene> load_scene(const std::string& name_or_file, const DataPaths& paths);

}  // namespace aprsim::scene
