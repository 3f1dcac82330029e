#include "world/scene/data_paths.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>

namespace aprsim::scene {

namespace fs = std::filesystem;

namespace {

DataPaths below(const fs::path& directory) {
  return {(directory / "scenes").string(), (directory / "models").string(),
          (directory / "scenarios").string()};
}

/// ../share/aprsim of the running binary; empty when the binary's path is not known.
fs::path installed_data() {
  std::error_code status;
  const fs::path binary = fs::read_symlink("/proc/self/exe", status);
  return status ? fs::path() : binary.parent_path().parent_path() / "share" / "aprsim";
}

}  // namespace

DataPaths default_data_paths() {
  if (const char* directory = std::getenv("APRSIM_DATA"); directory && *directory) {
    return below(directory);
  }
  std::error_code status;
  const fs::path installed = installed_data();
  if (!installed.empty() && fs::is_directory(installed / "scenes", status)) return below(installed);
  return below(APRSIM_DATA_SOURCE_DIR);
}

std::vector<std::string> names_in(const std::string& directory) {
  std::vector<std::string> names;
  std::error_code status;
  for (const auto& entry : fs::directory_iterator(directory, status)) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<std::string> scene_names(const DataPaths& paths) { return names_in(paths.scenes); }

}  // namespace aprsim::scene
