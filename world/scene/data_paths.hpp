#pragma once

#include <string>
#include <vector>

namespace aprsim::scene {

/// Directories that a scene name ("aprs") and its model files are looked up in.
struct DataPaths {
  std::string scenes;
  std::string models;
};

/// The data directories: $APRSIM_DATA/{scenes,models} when that is set, else ../share/aprsim of the
/// running binary when it is there (an installation), else those of the source tree.
[[nodiscard]] DataPaths default_data_paths();

/// Names of the scenes in the scenes directory, sorted.
[[nodiscard]] std::vector<std::string> scene_names(const DataPaths& paths);

}  // namespace aprsim::scene
