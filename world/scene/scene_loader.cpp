#include "world/scene/scene_loader.hpp"

#include <algorithm>
#include <filesystem>

#include "world/scene/object_reader.hpp"
#include "world/scene/overlap_check.hpp"
#include "world/scene/reading.hpp"

namespace aprsim::scene {

namespace fs = std::filesystem;

namespace {

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

/// One load: the scene's file, the files of types that it names, and what they hold.
class Loader {
 public:
  Loader(std::string file, const DataPaths& paths)
      : file_(std::move(file)),
        shipped_scenes_(paths.scenes),
        model_directories_{fs::path(file_).parent_path().string(), paths.models} {
    if (model_directories_.front().empty()) model_directories_.front() = ".";
  }

  Result<Scene> load() {
    auto document = yaml::Document::from_file(file_);
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
    if (!document->error()) check_overlaps(scene, nodes);
    if (document->error()) return tl::unexpected(*document->error());
    return scene;
  }

 private:
  /// Beside the scene, else among the shipped scenes; empty when in neither place.
  [[nodiscard]] fs::path find_types(const std::string& name) const {
    for (const fs::path& directory : {fs::path(file_).parent_path(), fs::path(shipped_scenes_)}) {
      std::error_code status;
      const fs::path path = directory / name;
      if (fs::is_regular_file(path, status)) return path;
    }
    return {};
  }

  Result<void> read_type_files(const yaml::Node& node) {
    if (!node) return {};
    const std::vector<yaml::Node> names = node.is_list() ? node.items() : std::vector{node};
    for (const yaml::Node& name : names) {
      const fs::path path = find_types(name.text());
      if (path.empty()) {
        const std::string beside = fs::path(file_).parent_path().string();
        name.unexpected("a file of types relative to the scene's directory" +
                            (beside.empty() ? "" : ", " + beside) + ", or to " + shipped_scenes_,
                        ErrorCode::kNotFound);
        return {};
      }
      auto document = yaml::Document::from_file(path.string());
      if (!document) return tl::unexpected(std::move(document.error()));
      read_types(document->root().map({"pockets", "gear_types", "tray_types", "robot_types"}),
                 model_directories_, types_);
      if (document->error()) return tl::unexpected(*document->error());
    }
    return {};
  }

  BodyNodes read_scene(const yaml::Map& keys, Scene& scene) {
    scene.name = fs::path(file_).stem().string();
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

Result<Scene> load_scene(const std::string& name_or_file, const DataPaths& paths) {
  auto file = find_scene(name_or_file, paths);
  if (!file) return tl::unexpected(std::move(file.error()));
  return Loader(std::move(*file), paths).load();
}

}  // namespace aprsim::scene
