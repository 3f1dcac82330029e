#pragma once

#include <string>
#include <vector>

namespace aprsim::scene {

/// Directories that the names of scenes ("aprs"), of their model files, of scenarios and of
/// extensions are looked up in.
struct DataPaths {
  std::string scenes;
  std::string models;
  std::string scenarios = {};
  std::vector<std::string> extensions = {};  ///< in the order of the search
};

/// The data directories: $APRSIM_DATA/{scenes,models,scenarios} when that is set, else
/// ../share/aprsim of the running binary when it is there (an installation), else those of the
/// source tree. Extensions: the added directories, those of $APRSIM_EXTENSIONS, which colons
/// separate, then ../lib/aprsim/extensions of the running binary. Thread: any.
[[nodiscard]] DataPaths default_data_paths();

/// From now on, this process looks up extensions in these directories, too, after those of earlier
/// calls. Thread: any.
void add_extension_directories(const std::vector<std::string>& directories);

/// Names of the YAML files in a directory, without their ending, sorted.
[[nodiscard]] std::vector<std::string> names_in(const std::string& directory);
/// Names of the scenes in the scenes directory, sorted.
[[nodiscard]] std::vector<std::string> scene_names(const DataPaths& paths);

}  // namespace aprsim::scene
