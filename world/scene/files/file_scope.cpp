#include "world/scene/files/file_scope.hpp"

#include <algorithm>
#include <filesystem>
#include <utility>

namespace aprsim::scene {

namespace fs = std::filesystem;

namespace {

fs::path normal(const fs::path& path) { return fs::absolute(path).lexically_normal(); }

/// Whether a normal path lies below a directory.
bool is_below(const fs::path& path, const fs::path& directory) {
  const fs::path base = normal(directory / "");
  const auto [end, at] = std::ranges::mismatch(base, path);
  // The last element of a directory with a slash is empty.
  return end == base.end() || std::next(end) == base.end();
}

}  // namespace

KnownFiles files_of(const Scene& scene) {
  KnownFiles files{.types = scene.type_files, .models = {}};
  for (const Robot& robot : scene.robots) files.models.push_back(robot.model_file);
  return files;
}

FileScope::FileScope(const std::string& file, ShippedFiles shipped)
    : directory_(fs::path(file).parent_path().string()), shipped_(std::move(shipped)) {
  if (directory_.empty()) directory_ = ".";
}

FileScope::FileScope(const std::string& file, ShippedFiles shipped, KnownFiles known)
    : FileScope(file, std::move(shipped)) {
  is_limited_ = true;
  known_ = std::move(known);
}

std::string FileScope::find(const std::string& name, const std::string& directory,
                            const std::string& shipped,
                            const std::vector<std::string>& known) const {
  const fs::path path = normal(fs::path(directory) / name);
  const bool may_be_read = !is_limited_ || is_below(path, shipped) ||
                           std::ranges::find(known, path.string()) != known.end();
  std::error_code status;
  return may_be_read && fs::is_regular_file(path, status) ? path.string() : std::string();
}

std::string FileScope::find_types(const std::string& name) const {
  const std::string beside = find(name, directory_, shipped_.types, known_.types);
  return beside.empty() ? find(name, shipped_.types, shipped_.types, known_.types) : beside;
}

std::string FileScope::find_model_beside(const std::string& name) const {
  return find(name, directory_, shipped_.models, known_.models);
}

std::string FileScope::find_model(const std::string& name) const {
  const std::string beside = find_model_beside(name);
  if (!beside.empty()) return beside;
  // A text that was sent may have the name of a known model alone.
  for (const std::string& model : known_.models) {
    if (fs::path(model).filename() == name) return model;
  }
  return find(name, shipped_.models, shipped_.models, known_.models);
}

std::string FileScope::expected_types() const {
  if (is_limited_) return "a file of types that comes with the daemon or that its scene names";
  return "a file of types relative to the scene's directory, " + directory_ + ", or to " +
         shipped_.types;
}

std::string FileScope::expected_model() const {
  if (is_limited_) return "a robot description that comes with the daemon or that its scene names";
  return "a robot description in " + directory_ + " or " + shipped_.models;
}

}  // namespace aprsim::scene
