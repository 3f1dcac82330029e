#pragma once

#include <string>
#include <vector>

namespace aprsim::scene {

/// Directories that the names of scenes ("aprs"), of their model files and of scenarios are looked
/// up in.
struct DataPaths {
  std::string scenes;
  std::string models;
  std::string scenarios = {};
};

/// The data directories: $APRSIM_DATA/{scenes,models,scenarios} when that is set, else
/// ../share/aprsim of the running binary when it is there (an installation), else those of the
/// source tree.
[[nodiscard]] DataPaths default_data_paths();

/// Names of the YAML files in a directory, without their ending, sorted.
[[nodiscard]] std::vector<std::string> names_in(const std::string& directory);
/// Names of the scenes in the scenes directory, sorted.
[[nodiscard]] std::vector<std::string> scene_names(const DataPaths& paths);

}  // namespace aprsim::scene
