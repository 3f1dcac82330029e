#pragma once

#include <optional>
#include <string>
#include <vector>

#include "world/base/result.hpp"
#include "world/base/yaml/key_recorder.hpp"
#include "world/scenario/scenario.hpp"
#include "world/scene/data_paths.hpp"

namespace aprsim::scenario {

/// Loads a scenario by name or by file path (anything with a slash or ending in .yaml). A scene
/// file is relative to the scenario's directory. Errors: as scene::load_scene, with file, line, key
/// and the expected value. References to the scene are checked as well.
[[nodiscard]] Result<Scenario> load_scenario(const std::string& name_or_file,
                                             const scene::DataPaths& paths);

/// The file of a scenario by name or by path. Error: as load_scenario.
[[nodiscard]] Result<std::string> find_scenario(const std::string& name_or_file,
                                                const scene::DataPaths& paths);

/// The errors of a scenario, as of load_scenario, all that can be found in one reading. `file` is
/// the place of the text.
[[nodiscard]] std::vector<Error> examine_scenario(const std::string& text, const std::string& file,
                                                  const scene::DataPaths& paths);

/// A scenario from outside: it may name shipped scenes and `own_scene`, cells by name, and options
/// of the controller that concern no files.
struct SentScope {
  std::string own_scene;  ///< absolute path of the daemon's scene
};

/// A scenario that is checked rather than loaded.
struct ExaminedScenario {
  std::vector<Error> errors;         ///< as of load_scenario, all that can be found in one reading
  std::optional<Scenario> scenario;  ///< if there are none
};

/// Reads a scenario from outside. Errors name "scenario text" in place of a file.
[[nodiscard]] ExaminedScenario examine_sent_scenario(const std::string& text,
                                                     const SentScope& scope,
                                                     const scene::DataPaths& paths);

/// The keys of scenario files, recorded from their reader.
[[nodiscard]] yaml::KeySchema scenario_keys();

/// Summary of a shipped scenario, without checks.
struct Summary {
  std::string description;
  std::string scene_file;      ///< file of the underlying scene
  bool changes_parts = false;  ///< as in Scenario
};

/// The summary of a shipped scenario. Error: the file cannot be read.
[[nodiscard]] Result<Summary> summarize_scenario(const std::string& name,
                                                 const scene::DataPaths& paths);

}  // namespace aprsim::scenario
