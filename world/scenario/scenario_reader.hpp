#pragma once

#include <string>

#include "world/base/result.hpp"
#include "world/scenario/scenario.hpp"
#include "world/scene/data_paths.hpp"

namespace aprsim::scenario {

/// Loads a scenario by name or by file path (anything with a slash or ending in .yaml). A scene in
/// it that is a file is looked for beside the scenario. Errors: as scene::load_scene, with file,
/// line, key and what was expected; what it asks of its scene is checked, too.
[[nodiscard]] Result<Scenario> load_scenario(const std::string& name_or_file,
                                             const scene::DataPaths& paths);

/// What a shipped scenario is, without all that it asks for.
struct Summary {
  std::string description;
  std::string scene_file;  ///< of the scene it is based on
  bool own_parts = false;  ///< as Scenario has it
};

/// The summary of a shipped scenario; its error, when that cannot be read.
[[nodiscard]] Result<Summary> summarize_scenario(const std::string& name,
                                                 const scene::DataPaths& paths);

}  // namespace aprsim::scenario
