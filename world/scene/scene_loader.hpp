#pragma once

#include <optional>
#include <string>
#include <vector>

#include "world/base/result.hpp"
#include "world/base/yaml/key_recorder.hpp"
#include "world/scene/data_paths.hpp"
#include "world/scene/files/file_scope.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::scene {

/// Loads a scene by name or by file path (anything with a slash or ending in .yaml). Unknown key,
/// wrong type, missing file, bad reference, interpenetrating objects: an error whose field is the
/// key's path and whose message reads "FILE:LINE:COLUMN: KEY: found ..., expected ...".
[[nodiscard]] Result<Scene> load_scene(const std::string& name_or_file, const DataPaths& paths);

/// The file of a scene by name or by path. Error: as load_scene.
[[nodiscard]] Result<std::string> find_scene(const std::string& name_or_file,
                                             const DataPaths& paths);

/// Reads a scene of the user's own from its text. `file` is the place of the text: messages name
/// it, and the text's relative paths start in its directory.
[[nodiscard]] Result<Scene> read_scene(const std::string& text, const std::string& file,
                                       const DataPaths& paths);

/// The same of a text from outside: it may name shipped and `known` files only (FileScope).
[[nodiscard]] Result<Scene> read_sent(const std::string& text, const std::string& file,
                                      const DataPaths& paths, KnownFiles known);

/// Reads a scene that was changed while its cell ran: overlaps are not checked.
[[nodiscard]] Result<Scene> read_edited(const std::string& text, const std::string& file,
                                        const DataPaths& paths);

/// The same of a text in a journal or saved state; see read_sent().
[[nodiscard]] Result<Scene> read_recorded(const std::string& text, const std::string& file,
                                          const DataPaths& paths, KnownFiles known);

/// A scene that is checked rather than loaded.
struct Examined {
  std::vector<Error> errors;   ///< as of load_scene, all that can be found in one reading
  std::optional<Scene> scene;  ///< if there are none
};

/// Reads a scene as read_scene() does and goes on after errors. Errors of its files of types are
/// among the others, each with its file; overlaps are searched if there are no other errors.
[[nodiscard]] Examined examine_scene(const std::string& text, const std::string& file,
                                     const DataPaths& paths);

/// Whether the text is one of a file of types: it has keys of types, and no others.
[[nodiscard]] bool has_types_only(const std::string& text, const std::string& file);

/// The errors of a file of types. Gears and pockets that it does not define may be in others.
[[nodiscard]] std::vector<Error> examine_types(const std::string& text, const std::string& file,
                                               const DataPaths& paths);

/// The keys of scene files and of files of types, recorded from the readers of this folder.
[[nodiscard]] yaml::KeySchema scene_keys();
[[nodiscard]] yaml::KeySchema type_keys();

/// Whether a name from outside can stand in a path without leading elsewhere.
[[nodiscard]] bool is_plain_name(const std::string& name);

/// A scene file's text with the types that it names made its own, so that it can be changed as a
/// whole and read from any place. Errors: as load_scene, of what it had to read.
[[nodiscard]] Result<std::string> self_contained(const std::string& file, const DataPaths& paths);

/// The text of a scene (Scene::text) with models by the names of their files alone: for whoever has
/// these beside it, anywhere. `file` stands in errors, as of load_scene.
[[nodiscard]] Result<std::string> portable_text(const std::string& text, const std::string& file);

}  // namespace aprsim::scene
