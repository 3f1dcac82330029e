#include "world/scene/scene_edit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string_view>
#include <utility>
#include <vector>

#include "world/base/yaml/yaml_tree.hpp"
#include "world/scene/data_paths.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::scene {
namespace {

using yaml::detail::Value;

Result<Value> tree_of(const Scene& scene) {
  if (scene.text.empty()) {
    return fail(ErrorCode::kUnimplemented, "scene", "scene " + scene.name + " has no text to edit");
  }
  return yaml::detail::parse(scene.text, scene.file);
}

Result<Scene> scene_of(const Value& tree, const Scene& before) {
  return read_edited(yaml::detail::write(tree), before.file, default_data_paths());
}

Value& child_of(Value& map, const std::string& key) {
  map.kind = Value::Kind::kMap;
  if (yaml::detail::Entry* entry = map.find(key)) return entry->value;
  map.entries.push_back({.key = key});
  return map.entries.back().value;
}

Value text_scalar(const std::string& text) {
  Value value;
  value.kind = Value::Kind::kScalar;
  value.scalar = text;
  value.quoted = true;
  return value;
}

/// Turns about the fixed axes x, y, z [deg].
Eigen::Vector3d rpy_deg(const Eigen::Quaterniond& q) {
  const Eigen::Matrix3d R = q.normalized().toRotationMatrix();
  const double pitch = std::asin(std::clamp(-R(2, 0), -1.0, 1.0));
  Eigen::Vector3d rpy(0, pitch, 0);
  if (std::abs(R(2, 0)) < 1 - 1e-12) {
    rpy[0] = std::atan2(R(2, 1), R(2, 2));
    rpy[2] = std::atan2(R(1, 0), R(0, 0));
  } else {
    rpy[2] = std::atan2(-R(0, 1), R(1, 1));  // x and z are one axis
  }
  return rpy * (180 / std::numbers::pi);
}

std::vector<std::string> split(const std::string& path) {
  std::vector<std::string> keys;
  std::size_t begin = 0;
  for (std::size_t dot; (dot = path.find('.', begin)) != std::string::npos; begin = dot + 1) {
    keys.push_back(path.substr(begin, dot - begin));
  }
  keys.push_back(path.substr(begin));
  return keys;
}

/// Whether a running cell can change the value: nothing that belongs to its state.
bool may_change(const std::vector<std::string>& keys) {
  if (std::ranges::find(keys, "") != keys.end() || keys.size() < 2) return false;
  if (keys[0] == "physics") return keys[1] != "step_s" && keys[1] != "simplification";
  if (keys[0] == "gear_types" || keys[0] == "tray_types") return keys.size() == 3;
  if (keys[0] == "part_types") return keys.size() == 3 && keys[2] != "pieces";
  if (keys[0] == "devices") return keys.size() == 4 && keys[2] == "parameters";
  return keys[0] == "robots" && keys.size() >= 4 && keys[2] == "vision" && keys[3] != "rate_hz" &&
         keys[3] != "latency_s";
}

/// The entry of a list with this name; null when there is none.
Value* named(Value& list, const std::string& name) {
  for (Value& item : list.items) {
    const yaml::detail::Entry* entry = item.find("name");
    if (entry != nullptr && entry->value.scalar == name) return &item;
  }
  return nullptr;
}

/// Whether both have the same number of everything, so that states fit both.
bool same_parts(const Scene& a, const Scene& b) {
  return a.robots.size() == b.robots.size() && a.trays.size() == b.trays.size() &&
         a.gears.size() == b.gears.size() && a.parts.size() == b.parts.size() &&
         tools_of(a).size() == tools_of(b).size();
}

}  // namespace

Result<Scene> with_body(const Scene& scene, const std::string& type, const std::string& name,
                        const Pose& X_WB) {
  auto tree = tree_of(scene);
  if (!tree) return tl::unexpected(std::move(tree.error()));
  const Eigen::Vector3d turns = rpy_deg(X_WB.q);
  Value body;
  child_of(body, "name") = text_scalar(name);
  child_of(body, "type") = text_scalar(type);
  child_of(body, "xyz_m") = yaml::detail::list({X_WB.p.x(), X_WB.p.y(), X_WB.p.z()});
  child_of(body, "rpy_deg") = yaml::detail::list({turns.x(), turns.y(), turns.z()});
  Value& bodies = child_of(*tree, scene.tray_types.contains(type)   ? "trays"
                                  : scene.part_types.contains(type) ? "parts"
                                                                    : "gears");
  bodies.kind = Value::Kind::kList;
  bodies.entries.clear();
  bodies.items.push_back(std::move(body));
  return scene_of(*tree, scene);
}

Result<Scene> with_value(const Scene& scene, const std::string& path, const std::string& value) {
  const std::vector<std::string> keys = split(path);
  if (!may_change(keys)) {
    return fail(
        ErrorCode::kInvalidArgument, "path",
        "'" + path +
            "' cannot be changed in a running cell; these values can: physics (except step_s and "
            "simplification), gear_types.TYPE, tray_types.TYPE, part_types.TYPE (except pieces), "
            "robots.NAME.vision (except rate_hz "
            "and latency_s), devices.NAME.parameters.PARAMETER");
  }
  auto tree = tree_of(scene);
  if (!tree) return tl::unexpected(std::move(tree.error()));
  auto parsed = yaml::detail::parse(value, "value");
  if (!parsed) return tl::unexpected(std::move(parsed.error()));
  Value* at = &*tree;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (at->kind == Value::Kind::kList) {
      at = named(*at, keys[i]);
    } else if (i == 1 && keys[0].ends_with("_types") && at->find(keys[i]) == nullptr) {
      at = nullptr;
    } else {
      at = &child_of(*at, keys[i]);
    }
    if (at == nullptr) {
      return fail(ErrorCode::kNotFound, "path", "'" + path + "': there is no '" + keys[i] + "'");
    }
  }
  *at = *std::move(parsed);
  auto edited = scene_of(*tree, scene);
  if (edited && !same_parts(*edited, scene)) {
    return fail(ErrorCode::kInvalidArgument, "path", "'" + path + "' changes what there is");
  }
  return edited;
}

}  // namespace aprsim::scene
