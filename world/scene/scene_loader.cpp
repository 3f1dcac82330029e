#include "world/scene/scene_loader.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <iterator>

#include "world/base/utf8.hpp"
#include "world/base/yaml/key_recorder.hpp"
#include "world/base/yaml/yaml_tree.hpp"
#include "world/scene/files/scene_overlay.hpp"
#include "world/scene/overlap_check.hpp"
#include "world/scene/readers/object_reader.hpp"
#include "world/scene/readers/piece_reader.hpp"
#include "world/scene/readers/reading.hpp"

namespace aprsim::scene {

namespace fs = std::filesystem;

namespace {

using yaml::detail::Value;

constexpr std::array<std::string_view, 5> kTypeKeys = {"pockets", "gear_types", "tray_types",
                                                       "part_types", "robot_types"};

/// Enough that each value is read in each of its forms.
constexpr int kRecordedRuns = 600;
constexpr std::string_view kBase = "base";

ShippedFiles shipped(const DataPaths& paths) { return {paths.scenes, paths.models}; }

/// Adds the entries of a map under `key` to the one in `root`.
void merge_map(const yaml::detail::Entry& from, Value& root) {
  yaml::detail::Entry* into = root.find(from.key);
  if (into == nullptr) {
    root.entries.push_back(from);
    return;
  }
  for (const auto& entry : from.value.entries) into->value.entries.push_back(entry);
}

Result<void> merge_types(const std::string& name, const FileScope& scope, Value& root) {
  const fs::path path = scope.find_types(name);
  if (path.empty()) {
    return fail(ErrorCode::kNotFound, "types",
                "types: found \"" + name + "\", expected " + scope.expected_types());
  }
  auto text = yaml::read_text(path.string());
  if (!text) return tl::unexpected(std::move(text.error()));
  const auto types = yaml::detail::parse(*text, path.string());
  if (!types) return tl::unexpected(types.error());
  for (const auto& entry : types->entries) {
    if (std::ranges::find(kTypeKeys, entry.key) != kTypeKeys.end()) merge_map(entry, root);
  }
  return {};
}

/// With its base and the types that it names made its own.
Result<Value> whole_tree(const std::string& text, const std::string& file, const FileScope& scope,
                         const DataPaths& paths, int depth = 0);

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
void make_models_absolute(const FileScope& scope, Value& root) {
  for_each_model(root, [&scope](std::string& model) {
    const std::string path = scope.find_model_beside(model);
    if (!path.empty()) model = path;
  });
}

constexpr std::array<std::string_view, 23> kSceneKeys = {
    "base",       "seed",          "types",       "physics",  "pockets",       "gear_types",
    "tray_types", "part_types",    "robot_types", "tools",    "robots",        "cameras",
    "conveyor",   "light_curtain", "fixed",       "fixtures", "holders",       "floor",
    "trays",      "gears",         "parts",       "devices",  "modbus_servers"};

/// One load: the scene's file, the files of types that it names, and what they hold.
class Loader {
 public:
  Loader(std::string file, const FileScope& scope) : file_(std::move(file)), scope_(scope) {}

  Result<Scene> load(Result<yaml::Document> document, bool check_places = true) {
    if (!document) return tl::unexpected(std::move(document.error()));
    const yaml::Map keys = document->root().map(kSceneKeys);
    refuse_base(keys[kBase]);
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

  /// Goes on after errors.
  Examined examine(Result<yaml::Document> document) {
    collects_ = true;
    if (!document) return {.errors = {std::move(document.error())}, .scene = std::nullopt};
    document->collect_errors();
    Scene scene;
    const yaml::Map keys = document->root().map(kSceneKeys);
    refuse_base(keys[kBase]);
    const auto read = read_type_files(keys["types"]);
    const bool has_types = std::ranges::none_of(document->errors(), [](const Error& error) {
      return error.field == "types" || error.field.starts_with("types[");
    });
    // Without its types, nothing of the scene makes sense.
    if (read && has_types) {
      const BodyNodes nodes = read_scene(keys, scene);
      if (!document->error() && errors_.empty()) check_overlaps(scene, nodes);
    } else if (!read) {
      errors_.push_back(read.error());
    }
    std::ranges::copy(document->errors(), std::back_inserter(errors_));
    if (!errors_.empty()) return {.errors = std::move(errors_), .scene = std::nullopt};
    return {.errors = {}, .scene = std::move(scene)};
  }

  /// The same of a file that has types only.
  std::vector<Error> examine_types(Result<yaml::Document> document) {
    if (!document) return {std::move(document.error())};
    document->collect_errors();
    read_types(document->root().map(kTypeKeys), scope_, types_);
    std::vector<Error> errors = document->errors();
    // Gears and pockets may be in other files that a scene names with this one.
    std::erase_if(errors, [](const Error& error) {
      return error.code == ErrorCode::kNotFound &&
             (error.field.ends_with(".gear") || error.field.ends_with(".pocket"));
    });
    return errors;
  }

 private:
  /// Bases are laid under before; texts of journals and edited scenes are whole.
  static void refuse_base(const yaml::Node& base) {
    if (base && !base.text().empty()) base.unexpected("a whole scene, which has no base");
  }
  Result<void> read_type_files(const yaml::Node& node) {
    if (!node) return {};
    const std::vector<yaml::Node> names = node.is_list() ? node.items() : std::vector{node};
    for (const yaml::Node& name : names) {
      const std::string path = scope_.find_types(name.text());
      if (path.empty()) {
        name.unexpected(scope_.expected_types(), ErrorCode::kNotFound);
        return {};
      }
      type_files_.push_back(path);
      auto document = yaml::Document::from_file(path);
      if (!document) return tl::unexpected(std::move(document.error()));
      if (collects_) document->collect_errors();
      read_types(document->root().map(kTypeKeys), scope_, types_);
      if (document->error() && !collects_) return tl::unexpected(*document->error());
      std::ranges::copy(document->errors(), std::back_inserter(errors_));
    }
    return {};
  }

  BodyNodes read_scene(const yaml::Map& keys, Scene& scene) {
    scene.name = utf8::valid(fs::path(file_).stem().string());
    scene.file = file_;
    scene.seed = static_cast<std::uint64_t>(keys["seed"].integer_or(1));
    scene.physics = read_physics(keys["physics"]);
    read_types(keys, scope_, types_);
    BodyNodes nodes = read_objects(keys, types_, scene);
    scene.gear_types = types_.gears;
    scene.tray_types = types_.trays;
    scene.part_types = types_.parts;
    if (keys["physics"]) check_materials(keys["physics"].map(kPhysicsKeys)["materials"], scene);
    scene.type_files = type_files_;
    return nodes;
  }

  std::string file_;
  const FileScope& scope_;
  std::vector<std::string> type_files_;
  Types types_;
  bool collects_ = false;
  std::vector<Error> errors_;  // of files of types
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
              "scene: found no scene \"" + name_or_file + "\", expected one of " +
                  (list.empty() ? "(there is none)" : list) +
                  (near.empty() ? "" : " (did you mean " + near + "?)"));
}

Result<Scene> load_scene(const std::string& name_or_file, const DataPaths& paths) {
  auto file = find_scene(name_or_file, paths);
  if (!file) return tl::unexpected(std::move(file.error()));
  auto text = yaml::read_text(*file);
  if (!text) return tl::unexpected(std::move(text.error()));
  return read_scene(*text, *file, paths);
}

namespace {

/// A scene with a base is read from the whole tree, whose values know their places in both files.
Result<yaml::Document> document_of(const std::string& text, const std::string& file,
                                   const FileScope& scope, const DataPaths& paths) {
  const auto own = yaml::detail::parse(text, file);
  if (!own || own->find(kBase) == nullptr) return yaml::Document::from_text(text, file);
  auto whole = whole_tree(text, file, scope, paths);
  if (!whole) return tl::unexpected(std::move(whole.error()));
  return yaml::Document::from_tree(*std::move(whole));
}

Result<Scene> read_whole(const std::string& text, const std::string& file, const FileScope& scope,
                         const DataPaths& paths) {
  auto scene = Loader(file, scope).load(document_of(text, file, scope, paths));
  if (!scene) return scene;
  const auto whole = whole_tree(text, file, scope, paths);
  if (!whole) return tl::unexpected(whole.error());
  scene->text = yaml::detail::write(*whole);
  return scene;
}

Result<Scene> read_unchecked(const std::string& text, const std::string& file,
                             const FileScope& scope) {
  auto scene = Loader(file, scope).load(yaml::Document::from_text(text, file), false);
  if (scene) scene->text = text;
  return scene;
}

/// A text that was sent has no file: `file` is a place for its relative paths, maybe the daemon's
/// own, which errors do not show.
Result<Scene> of_text(Result<Scene> scene, const std::string& file) {
  constexpr std::string_view kName = "scene text";
  if (scene) return scene;
  std::string& message = scene.error().message;
  for (auto at = message.find(file); at != std::string::npos; at = message.find(file, at)) {
    message.replace(at, file.size(), kName);
    at += kName.size();
  }
  return scene;
}

}  // namespace

Result<Scene> read_scene(const std::string& text, const std::string& file, const DataPaths& paths) {
  return read_whole(text, file, FileScope(file, shipped(paths)), paths);
}

bool has_types_only(const std::string& text, const std::string& file) {
  const auto root = yaml::detail::parse(text, file);
  return root && !root->entries.empty() &&
         std::ranges::all_of(root->entries, [](const auto& entry) {
           return std::ranges::find(kTypeKeys, entry.key) != kTypeKeys.end();
         });
}

Examined examine_scene(const std::string& text, const std::string& file, const DataPaths& paths) {
  const FileScope scope(file, shipped(paths));
  Examined out = Loader(file, scope).examine(document_of(text, file, scope, paths));
  if (!out.scene) return out;
  const auto whole = whole_tree(text, file, scope, paths);
  if (whole) out.scene->text = yaml::detail::write(*whole);
  return out;
}

std::vector<Error> examine_types(const std::string& text, const std::string& file,
                                 const DataPaths& paths) {
  const FileScope scope(file, shipped(paths));
  return Loader(file, scope).examine_types(yaml::Document::from_text(text, file));
}

yaml::KeySchema scene_keys() {
  yaml::KeyRecorder recorder;
  const FileScope nowhere("/dev/null/scene.yaml", {"/dev/null", "/dev/null"});
  for (int run = 0; run < kRecordedRuns; ++run) {
    recorder.begin_run();
    static_cast<void>(Loader("recorded", nowhere).load(yaml::Document::recorded(recorder), false));
    recorder.end_run();
  }
  return recorder.schema();
}

yaml::KeySchema type_keys() {
  yaml::KeySchema keys = scene_keys();
  std::erase_if(keys.keys, [](const yaml::KeyEntry& entry) {
    return std::ranges::find(kTypeKeys, entry.key) == kTypeKeys.end();
  });
  return keys;
}

Result<Scene> read_sent(const std::string& text, const std::string& file, const DataPaths& paths,
                        KnownFiles known) {
  return of_text(read_whole(text, file, FileScope(file, shipped(paths), std::move(known)), paths),
                 file);
}

Result<Scene> read_edited(const std::string& text, const std::string& file,
                          const DataPaths& paths) {
  return read_unchecked(text, file, FileScope(file, shipped(paths)));
}

Result<Scene> read_recorded(const std::string& text, const std::string& file,
                            const DataPaths& paths, KnownFiles known) {
  return of_text(read_unchecked(text, file, FileScope(file, shipped(paths), std::move(known))),
                 file);
}

bool is_plain_name(const std::string& name) {
  return !name.empty() && name != "." && name != ".." && name.find('/') == std::string::npos &&
         name.find('\0') == std::string::npos;
}

Result<std::string> self_contained(const std::string& file, const DataPaths& paths) {
  auto text = yaml::read_text(file);
  if (!text) return tl::unexpected(std::move(text.error()));
  const auto whole = whole_tree(*text, file, FileScope(file, shipped(paths)), paths);
  if (!whole) return tl::unexpected(whole.error());
  return yaml::detail::write(*whole);
}

Result<std::string> portable_text(const std::string& text, const std::string& file) {
  auto root = yaml::detail::parse(text, file);
  if (!root) return tl::unexpected(std::move(root.error()));
  for_each_model(*root, [](std::string& model) { model = fs::path(model).filename().string(); });
  return yaml::detail::write(*root);
}

namespace {

/// The tree of the scene that `name` in `file` stands for.
Result<Value> base_tree(const yaml::detail::Entry& entry, const FileScope& scope,
                        const DataPaths& paths, int depth) {
  constexpr int kMostBases = 8;
  const std::string& name = entry.value.scalar;
  const std::string at = entry.value.mark.text() + ": base: ";
  if (depth == kMostBases) {
    return fail(ErrorCode::kInvalidArgument, "base",
                at + "found \"" + name + "\", expected at most " + std::to_string(kMostBases) +
                    " scenes, one the base of the next");
  }
  const bool is_file = name.ends_with(".yaml") || name.ends_with(".yml");
  const std::string file = scope.find_types(is_file ? name : name + ".yaml");
  if (entry.value.kind != Value::Kind::kScalar || file.empty()) {
    return fail(ErrorCode::kNotFound, "base",
                at + "found \"" + name + "\", expected the name of a scene or a scene's file");
  }
  auto text = yaml::read_text(file);
  if (!text) return tl::unexpected(std::move(text.error()));
  return whole_tree(*text, file, FileScope(file, shipped(paths)), paths, depth + 1);
}

Result<Value> whole_tree(const std::string& text, const std::string& file, const FileScope& scope,
                         const DataPaths& paths, int depth) {
  auto root = yaml::detail::parse(text, file);
  if (!root) return tl::unexpected(std::move(root.error()));
  const yaml::detail::Entry* types = root->find("types");
  if (types != nullptr) {
    const Value names = types->value;
    const std::vector<Value> all =
        names.kind == Value::Kind::kList ? names.items : std::vector{names};
    for (const Value& name : all) {
      if (auto merged = merge_types(name.scalar, scope, *root); !merged) {
        return tl::unexpected(std::move(merged.error()));
      }
    }
    std::erase_if(root->entries, [](const auto& entry) { return entry.key == "types"; });
  }
  make_models_absolute(scope, *root);
  const yaml::detail::Entry* base = root->find(kBase);
  if (base == nullptr) return root;
  auto whole = base_tree(*base, scope, paths, depth);
  if (!whole) return whole;
  std::erase_if(root->entries, [](const auto& entry) { return entry.key == kBase; });
  lay_over(*whole, *std::move(root));
  return whole;
}

}  // namespace

}  // namespace aprsim::scene
