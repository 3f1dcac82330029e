#include "world/scene/scene_loader.hpp"

#include <algorithm>
#include <array>
#include <filesystem>

#include "world/base/utf8_text.hpp"
#include "world/base/yaml/yaml_tree.hpp"
#include "world/scene/overlap_check.hpp"
#include "world/scene/readers/object_reader.hpp"
#include "world/scene/readers/reading.hpp"

namespace aprsim::scene {

namespace fs = std::filesystem;

namespace {

using yaml::detail::Value;

constexpr std::array<std::string_view, 4> kTypeKeys = {"pockets", "gear_types", "tray_types",
                                                       "robot_types"};

/// A file of types beside the scene, else among the shipped scenes; empty when in neither place.
fs::path find_types(const std::string& name, const std::string& scene, const std::string& shipped) {
  for (const fs::path& directory : {fs::path(scene).parent_path(), fs::path(shipped)}) {
    std::error_code status;
    const fs::path path = directory / name;
    if (fs::is_regular_file(path, status)) return path;
  }
  return {};
}

/// Adds the entries of a map under `key` to the one in `root`.
void merge_map(const yaml::detail::Entry& from, Value& root) {
  yaml::detail::Entry* into = root.find(from.key);
  if (into == nullptr) {
    root.entries.push_back(from);
    return;
  }
  for (const auto& entry : from.value.entries) into->value.entries.push_back(entry);
}

Result<void> merge_types(const std::string& name, const std::string& scene, const DataPaths& paths,
                         Value& root) {
  const fs::path path = find_types(name, scene, paths.scenes);
  auto text = yaml::read_text(path.empty() ? name : path.string());
  if (!text) return tl::unexpected(std::move(text.error()));
  const auto types = yaml::detail::parse(*text, path.string());
  if (!types) return tl::unexpected(types.error());
  for (const auto& entry : types->entries) {
    if (std::ranges::find(kTypeKeys, entry.key) != kTypeKeys.end()) merge_map(entry, root);
  }
  return {};
}

/// With the types that it names made its own.
Result<std::string> whole_text(const std::string& text, const std::string& file,
                               const DataPaths& paths);

/// Calls `change` with the path of each model that the scene names.
template <typename Change>
void for_each_model(Value& root, const Change& change) {
  yaml::detail::Entry* robots = root.find("robot_types");
  if (robots == nullptr) return;
  for (auto& robot : robots->value.entries) {
    if (yaml::detail::Entry* model = robot.value.find("model")) change(model->value.scalar);
  }
}

/// Models beside the scene keep their place; shipped ones are found from everywhere.
void make_models_absolute(const fs::path& directory, Value& root) {
  for_each_model(root, [&directory](std::string& model) {
    std::error_code status;
    const fs::path path = directory / model;
    if (fs::is_regular_file(path, status)) model = fs::absolute(path, status).string();
  });
}

/// One load: the scene's file, the files of types that it names, and what they hold.
class Loader {
 public:
  Loader(std::string file, const DataPaths& paths)
      : file_(std::move(file)),
        shipped_scenes_(paths.scenes),
        model_directories_{fs::path(file_).parent_path().string(), paths.models} {
    if (model_directories_.front().empty()) model_directories_.front() = ".";
  }

  Result<Scene> load(Result<yaml::Document> document, bool check_places = true) {
    if (!document) return tl::unexpected(std::move(document.error()));
    const yaml::Map keys = document->root().map(
        {"seed", "types", "physics", "pockets", "gear_types", "tray_types", "robot_types", "tools",
         "robots", "conveyor", "light_curtain", "fixed", "holders", "floor", "trays", "gears"});
    if (document->error()) return tl::unexpected(*document->error());
    if (auto read = read_type_files(keys["types"]); !read) {
      return tl::unexpected(std::move(read.error()));
    }
    Scene scene;
    const BodyNodes nodes = read_scene(keys, scene);
    if (!document->error() && check_places) check_overlaps(scene, nodes);
    if (document->error()) return tl::unexpected(*document->error());
    return scene;
  }

 private:
  Result<void> read_type_files(const yaml::Node& node) {
    if (!node) return {};
    const std::vector<yaml::Node> names = node.is_list() ? node.items() : std::vector{node};
    for (const yaml::Node& name : names) {
      const fs::path path = find_types(name.text(), file_, shipped_scenes_);
      if (path.empty()) {
        const std::string beside = fs::path(file_).parent_path().string();
        name.unexpected("a file of types relative to the scene's directory" +
                            (beside.empty() ? "" : ", " + beside) + ", or to " + shipped_scenes_,
                        ErrorCode::kNotFound);
        return {};
      }
      auto document = yaml::Document::from_file(path.string());
      if (!document) return tl::unexpected(std::move(document.error()));
      read_types(document->root().map(kTypeKeys), model_directories_, types_);
      if (document->error()) return tl::unexpected(*document->error());
    }
    return {};
  }

  BodyNodes read_scene(const yaml::Map& keys, Scene& scene) {
    scene.name = utf8_text(fs::path(file_).stem().string());
    scene.file = file_;
    scene.seed = static_cast<std::uint64_t>(keys["seed"].integer_or(1));
    scene.physics = read_physics(keys["physics"]);
    read_types(keys, model_directories_, types_);
    BodyNodes nodes = read_objects(keys, types_, scene);
    scene.gear_types = types_.gears;
    scene.tray_types = types_.trays;
    return nodes;
  }

  std::string file_;
  std::string shipped_scenes_;
  std::vector<std::string> model_directories_;
  Types types_;
};

}  // namespace

Result<std::string> find_scene(const std::string& name_or_file, const DataPaths& paths) {
  const bool is_file = name_or_file.find('/') != std::string::npos ||
                       name_or_file.ends_with(".yaml") || name_or_file.ends_with(".yml");
  if (is_file) return name_or_file;
  const fs::path path = fs::path(paths.scenes) / (name_or_file + ".yaml");
  std::error_code status;
  if (!name_or_file.empty() && fs::is_regular_file(path, status)) return path.string();
  std::string list;
  const std::vector<std::string> names = scene_names(paths);
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  const std::string near = yaml::nearest_word(name_or_file, names);
  return fail(ErrorCode::kNotFound, "scene",
              "scene: found no scene \"" + name_or_file + "\" in " + paths.scenes +
                  ", expected one of " + (list.empty() ? "(none there)" : list) +
                  (near.empty() ? "" : " (did you mean " + near + "?)"));
}

Result<Scene> load_scene(const std::string& name_or_file, const DataPaths& paths) {
  auto file = find_scene(name_or_file, paths);
  if (!file) return tl::unexpected(std::move(file.error()));
  auto text = yaml::read_text(*file);
  if (!text) return tl::unexpected(std::move(text.error()));
  return read_scene(*text, *file, paths);
}

Result<Scene> read_scene(const std::string& text, const std::string& file, const DataPaths& paths) {
  auto scene = Loader(file, paths).load(yaml::Document::from_text(text, file));
  if (!scene) return scene;
  auto whole = whole_text(text, file, paths);
  if (!whole) return tl::unexpected(std::move(whole.error()));
  scene->text = *std::move(whole);
  return scene;
}

Result<Scene> read_edited(const std::string& text, const std::string& file,
                          const DataPaths& paths) {
  auto scene = Loader(file, paths).load(yaml::Document::from_text(text, file), false);
  if (scene) scene->text = text;
  return scene;
}

Result<std::string> self_contained(const std::string& file, const DataPaths& paths) {
  auto text = yaml::read_text(file);
  if (!text) return tl::unexpected(std::move(text.error()));
  return whole_text(*text, file, paths);
}

Result<std::string> portable_text(const std::string& text, const std::string& file) {
  auto root = yaml::detail::parse(text, file);
  if (!root) return tl::unexpected(std::move(root.error()));
  for_each_model(*root, [](std::string& model) { model = fs::path(model).filename().string(); });
  return yaml::detail::write(*root);
}

namespace {

Result<std::string> whole_text(const std::string& text, const std::string& file,
                               const DataPaths& paths) {
  auto root = yaml::detail::parse(text, file);
  if (!root) return tl::unexpected(std::move(root.error()));
  const yaml::detail::Entry* types = root->find("types");
  if (types != nullptr) {
    const Value names = types->value;
    const std::vector<Value> all =
        names.kind == Value::Kind::kList ? names.items : std::vector{names};
    for (const Value& name : all) {
      if (auto merged = merge_types(name.scalar, file, paths, *root); !merged) {
        return tl::unexpected(std::move(merged.error()));
      }
    }
    std::erase_if(root->entries, [](const auto& entry) { return entry.key == "types"; });
  }
  make_models_absolute(fs::path(file).parent_path(), *root);
  return yaml::detail::write(*root);
}

}  // namespace

}  // namespace aprsim::scene
