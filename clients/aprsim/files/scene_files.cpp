#include "clients/aprsim/files/scene_files.hpp"

#include <algorithm>
#include <charconv>
#include <regex>
#include <set>
#include <tuple>

#include "clients/aprsim/files/reach.hpp"
#include "world/base/yaml/yaml_reader.hpp"
#include "world/base/yaml/yaml_tree.hpp"
#include "world/scenario/scenario_reader.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::client {
namespace {

Failure wrong_file(const Error& error) { return {FailureKind::kUsage, error.message}; }

int number_of(const std::string& digits) {
  int value = 0;
  std::from_chars(digits.data(), digits.data() + digits.size(), value);
  return value;
}

/// Messages of readers begin with "FILE:LINE:COLUMN: KEY: ".
Problem problem_of(const Error& error, const std::string& file) {
  static const std::regex kPlace(R"(^(.+?):(\d+):(\d+): )");
  Problem problem{.file = file, .key = error.field, .message = error.message};
  std::smatch place;
  if (std::regex_search(error.message, place, kPlace)) {
    problem.file = place[1];
    problem.line = number_of(place[2]);
    problem.column = number_of(place[3]);
    problem.message = place.suffix();
  }
  const std::string key = error.field + ": ";
  if (!error.field.empty() && problem.message.starts_with(key)) {
    problem.message.erase(0, key.size());
  }
  return problem;
}

/// The place of a key of the scene's own file; of the file's start if another file has it.
Problem warning_at(const FoundFile& file, const yaml::detail::Value* value, std::string key,
                   std::string message) {
  Problem out{.file = file.path, .key = std::move(key), .message = std::move(message)};
  out.is_warning = true;
  if (value != nullptr) {
    out.line = value->mark.line;
    out.column = value->mark.column;
  }
  return out;
}

/// Names of all types that the scene uses.
std::set<std::string> used_types(const yaml::detail::Value& value) {
  std::set<std::string> used;
  for (const auto& item : value.items) used.merge(used_types(item));
  for (const auto& entry : value.entries) {
    const bool names_type = entry.key == "type" || entry.key == "gear" || entry.key == "pocket";
    if (names_type) used.insert(entry.value.scalar);
    used.merge(used_types(entry.value));
  }
  return used;
}

void warn_of_unused_types(const FoundFile& file, const yaml::detail::Value& root,
                          std::vector<Problem>& out) {
  const std::set<std::string> used = used_types(root);
  for (const char* kind : {"pockets", "gear_types", "part_types", "tray_types", "robot_types"}) {
    const yaml::detail::Entry* types = root.find(kind);
    if (types == nullptr) continue;
    for (const auto& type : types->value.entries) {
      if (used.contains(type.key)) continue;
      out.push_back(warning_at(file, &type.value, std::string(kind) + '.' + type.key,
                               "found a type that nothing in this file uses"));
    }
  }
}

/// The entry of a list of bodies that has the name or, as a tray, holds it.
const yaml::detail::Value* body_named(const yaml::detail::Value& root, const std::string& name) {
  for (const char* list : {"gears", "parts", "trays"}) {
    const yaml::detail::Entry* bodies = root.find(list);
    if (bodies == nullptr) continue;
    for (const auto& body : bodies->value.items) {
      const yaml::detail::Entry* own = body.find("name");
      if (own != nullptr && own->value.scalar == name) return &body;
      const yaml::detail::Entry* gears = body.find("gears");
      if (gears == nullptr) continue;
      for (const auto& gear : gears->value.entries) {
        const yaml::detail::Entry* inner = gear.value.find("name");
        if ((inner == nullptr ? gear.value : inner->value).scalar == name) return &gear.value;
      }
    }
  }
  return nullptr;
}

void warn_of_scene(const FoundFile& file, const scene::Scene& scene, std::vector<Problem>& out) {
  const auto root = yaml::detail::parse(file.text, file.path);
  if (!root) return;
  for (const std::string& body : bodies_out_of_reach(scene)) {
    out.push_back(warning_at(file, body_named(*root, body), body,
                             "found a place that no robot reaches with its tool downwards"));
  }
  warn_of_unused_types(file, *root, out);
}

}  // namespace

std::size_t CheckedFile::errors() const {
  return static_cast<std::size_t>(std::ranges::count(problems, false, &Problem::is_warning));
}

Outcome<FoundFile> find_file(FileKind kind, const std::string& name_or_file,
                             const scene::DataPaths& paths) {
  const auto path = kind == FileKind::kScenario ? scenario::find_scenario(name_or_file, paths)
                                                : scene::find_scene(name_or_file, paths);
  if (!path) return tl::unexpected(wrong_file(path.error()));
  auto text = yaml::read_text(*path);
  if (!text) return tl::unexpected(wrong_file(text.error()));
  FoundFile out{.path = *path, .text = *std::move(text), .kind = kind};
  if (kind == FileKind::kScene && scene::has_types_only(out.text, out.path)) {
    out.kind = FileKind::kTypes;
  }
  return out;
}

CheckedFile check_file(const FoundFile& found, const scene::DataPaths& paths) {
  CheckedFile out{.file = found.path, .kind = found.kind};
  std::vector<Error> errors;
  if (found.kind == FileKind::kScenario) {
    errors = scenario::examine_scenario(found.text, found.path, paths);
  } else if (found.kind == FileKind::kTypes) {
    errors = scene::examine_types(found.text, found.path, paths);
  } else {
    scene::Examined examined = scene::examine_scene(found.text, found.path, paths);
    errors = std::move(examined.errors);
    out.scene = std::move(examined.scene);
  }
  for (const Error& error : errors) out.problems.push_back(problem_of(error, found.path));
  std::ranges::stable_sort(out.problems, {}, [](const Problem& problem) {
    return std::tie(problem.file, problem.line, problem.column);
  });
  if (out.scene) warn_of_scene(found, *out.scene, out.problems);
  return out;
}

}  // namespace aprsim::client
