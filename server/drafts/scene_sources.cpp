#include "server/drafts/scene_sources.hpp"

#include <algorithm>
#include <filesystem>
#include <optional>

#include "world/base/yaml/yaml_tree.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::server {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kDraftBytes = std::size_t{4} << 20;

/// The text of a file if it makes this cell. A scene with a base has only what differs from it.
std::optional<std::string> text_of(const std::string& file, const std::string& composed) {
  auto text = yaml::read_text(file);
  if (!text) return std::nullopt;
  const auto tree = yaml::detail::parse(*text, file);
  if (!tree || tree->find("base") != nullptr) return std::nullopt;
  const auto scene = scene::read_scene(*text, file, scene::default_data_paths());
  if (!scene || scene->text != composed) return std::nullopt;
  return *std::move(text);
}

/// Shipped files of types, then those of the scene that are beside it.
std::vector<web::TypesFile> types_of(const scene::Scene& scene) {
  const std::string folder = scene::default_data_paths().scenes;
  std::vector<web::TypesFile> out;
  const auto add = [&out](const std::string& name, const std::string& file) {
    if (std::ranges::find(out, name, &web::TypesFile::file) != out.end()) return;
    if (auto text = yaml::read_text(file)) out.push_back({name, *std::move(text)});
  };
  for (const std::string& name : scene::names_in(folder + "/types")) {
    add("types/" + name + ".yaml", folder + "/types/" + name + ".yaml");
  }
  const fs::path beside = fs::path(scene.file).parent_path();
  for (const std::string& file : scene.type_files) {
    add(fs::path(file).lexically_relative(fs::absolute(beside)).generic_string(), file);
  }
  return out;
}

}  // namespace

web::SceneSource SceneSources::find(const api::CellDescription& cell) const {
  web::SceneSource out;
  out.types = types_of(*scene_);
  out.text = cell.scene_text ? *cell.scene_text : scene_->text;
  const auto draft = std::ranges::find(drafts_, out.text, [](const auto& d) { return d.first; });
  if (draft != drafts_.end()) {
    out.text = draft->second;
    out.as_written = true;
    return out;
  }
  const std::string shipped = scene::default_data_paths().scenes + "/" + cell.scene + ".yaml";
  for (const std::string& file : {scene_->file, shipped}) {
    if (auto text = text_of(file, out.text)) {
      out.text = *std::move(text);
      out.as_written = true;
      break;
    }
  }
  return out;
}

void SceneSources::keep(std::string composed, std::string text) {
  std::erase_if(drafts_, [&](const auto& draft) { return draft.first == composed; });
  drafts_.emplace_front(std::move(composed), std::move(text));
  std::size_t bytes = 0, kept = 0;
  for (const auto& [whole, written] : drafts_) {
    bytes += whole.size() + written.size();
    if (bytes > kDraftBytes) break;
    ++kept;
  }
  drafts_.resize(kept);
}

}  // namespace aprsim::server
