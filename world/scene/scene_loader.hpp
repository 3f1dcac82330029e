#pragma once

#include <string>

#include "world/base/result.hpp"
#include "world/scene/data_paths.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::scene {

/// Loads a scene by name or by file path (anything with a slash or ending in .yaml). Unknown key,
/// wrong type, missing file, bad reference, interpenetrating objects: an error whose field is the
/// key's path and whose message reads "FILE:LINE:COLUMN: KEY: found ..., expected ...".
[[nodiscard]] Result<Scene> load_scene(const std::string& name_or_file, const DataPaths& paths);

/// The file of a scene by name or by path. Error: as load_scene.
[[nodiscard]] Result<std::string> find_scene(const std::string& name_or_file,
                                             const DataPaths& paths);

/// A scene from its text; `file` is where the text belongs: it stands in messages, and what the
/// text names by relative paths is looked for beside it.
[[nodiscard]] Result<Scene> read_scene(const std::string& text, const std::string& file,
                                       const DataPaths& paths);

/// The same of a scene that has been changed while its cell ran: whether things are in each other's
/// way is not checked.
[[nodiscard]] Result<Scene> read_edited(const std::string& text, const std::string& file,
                                        const DataPaths& paths);

/// A scene file's text with the types that it names made its own, so that it can be changed as a
/// whole and read from any place. Errors: as load_scene, of what it had to read.
[[nodiscard]] Result<std::string> self_contained(const std::string& file, const DataPaths& paths);

/// The text of a scene (Scene::text) with models by the names of their files alone: for whoever has
/// these beside it, anywhere. `file` stands in errors, as of load_scene.
[[nodiscard]] Result<std::string> portable_text(const std::string& text, const std::string& file);

}  // namespace aprsim::scene
