#pragma once

#include <string>
#include <vector>

#include "world/api/error.hpp"
#include "world/scene/scene.hpp"

namespace aprsim::scene {

/// Directories that a scene name ("aprs") and its model files are looked up in.
struct DataPaths {
  std::string scenes;
  std::string models;
};

/// The data directories: $APRSIM_DATA/{scenes,models} when that is set, else ../share/aprsim of the
/// running binary when it is there (an installation), else those of the source tree.
[[nodiscard]] DataPaths default_data_paths();

/// Loads a scene by name or by file path (anything with a slash or ending in .yaml). Unknown key,
/// wrong type, missing file, bad reference, interpenetrating objects: an error whose field is the
/// key's path and whose message reads "FILE:LINE:COLUMN: KEY: found ..., expected ...".
[[nodiscard]] Result<Scene> load_scene(const std::string& name_or_file, const DataPaths& paths);

/// Names of the scenes in the scenes directory, sorted.
[[nodiscard]] std::vector<std::string> scene_names(const DataPaths& paths);

}  // namespace aprsim::scene
