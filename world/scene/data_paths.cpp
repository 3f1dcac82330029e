#include "world/scene/data_paths.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <mutex>
#include <string_view>

namespace aprsim::scene {

namespace fs = std::filesystem;

namespace {

DataPaths below(const fs::path& directory) {
  return {(directory / "scenes").string(), (directory / "models").string(),
          (directory / "scenarios").string()};
}

/// The directory above that of the running binary; empty when the binary's path is not known.
fs::path installation() {
  std::error_code status;
  const fs::path binary = fs::read_symlink("/proc/self/exe", status);
  return status ? fs::path() : binary.parent_path().parent_path();
}

DataPaths data_paths() {
  if (const char* directory = std::getenv("APRSIM_DATA"); directory && *directory) {
    return below(directory);
  }
  std::error_code status;
  const fs::path installed = installation() / "share" / "aprsim";
  if (installed.is_absolute() && fs::is_directory(installed / "scenes", status)) {
    return below(installed);
  }
  return below(APRSIM_DATA_SOURCE_DIR);
}

struct AddedDirectories {
  std::mutex mutex;
  std::vector<std::string> all;
};
AddedDirectories& added_directories() {
  static AddedDirectories added;
  return added;
}

void add(std::vector<std::string>& to, std::string_view directory) {
  if (directory.empty() || std::ranges::find(to, directory) != to.end()) return;
  to.emplace_back(directory);
}

std::vector<std::string> extension_directories() {
  AddedDirectories& added = added_directories();
  std::unique_lock lock(added.mutex);
  std::vector<std::string> all = added.all;
  lock.unlock();
  const char* listed = std::getenv("APRSIM_EXTENSIONS");
  for (std::string_view rest = listed ? listed : ""; !rest.empty();) {
    const std::string_view one = rest.substr(0, rest.find(':'));
    add(all, one);
    rest.remove_prefix(std::min(one.size() + 1, rest.size()));
  }
  const fs::path installed = installation() / "lib" / "aprsim" / "extensions";
  if (installed.is_absolute()) add(all, installed.string());
  return all;
}

}  // namespace

DataPaths default_data_paths() {
  DataPaths paths = data_paths();
  paths.extensions = extension_directories();
  return paths;
}

void add_extension_directories(const std::vector<std::string>& directories) {
  AddedDirectories& added = added_directories();
  const std::lock_guard lock(added.mutex);
  for (const std::string& directory : directories) add(added.all, directory);
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
