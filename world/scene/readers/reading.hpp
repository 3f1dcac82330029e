#pragma once

#include <map>
#include <string>
#include <vector>

#include "world/api/values/pose.hpp"
#include "world/base/yaml/yaml_reader.hpp"

/// Pieces that all parts of a scene file are read with. Errors go to the node's document.
namespace aprsim::scene {

/// Degrees to radians.
[[nodiscard]] double radians(double degrees);

/// No place and no length of a cell is further than this from zero [m].
inline constexpr double kFar = 1000;
/// Permitted lengths [m].
inline constexpr yaml::Range kLength{.min = 0, .max = kFar, .open_min = true};

[[nodiscard]] Eigen::Vector2d read_xy(const yaml::Node& node);
[[nodiscard]] Eigen::Vector3d read_xyz(const yaml::Node& node,
                                       const yaml::Range& range = yaml::between(-kFar, kFar));

/// From the keys xyz_m and rpy_deg (turns about the fixed axes x, y, z in this order; optional).
[[nodiscard]] Pose read_pose(const yaml::Node& xyz_m, const yaml::Node& rpy_deg);
/// From a map of these two keys; identity when absent.
[[nodiscard]] Pose read_pose_map(const yaml::Node& node);

/// A name that every wire can carry: letters, digits, '_', '-' and '.'.
void check_name(const yaml::Node& node, const std::string& name);
[[nodiscard]] std::string read_name(const yaml::Node& node);

/// LINE:COLUMN: KEY of a value, for errors that are found later.
[[nodiscard]] std::string place_of(const yaml::Node& node);

/// Error "found X, expected one of ... (did you mean ...?)" where a reference leads nowhere.
void report_unknown(const yaml::Node& node, const std::string& name, const std::string& what,
                    const std::vector<std::string>& known);

template <typename T>
[[nodiscard]] std::vector<std::string> keys_of(const std::map<std::string, T>& map) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : map) keys.push_back(key);
  return keys;
}

/// The value that the node's text names; null (and an error) if there is no such thing.
template <typename T>
[[nodiscard]] const T* read_reference(const yaml::Node& node, const std::string& what,
                                      const std::map<std::string, T>& known) {
  const std::string name = node.text();
  const auto it = known.find(name);
  if (it != known.end()) return &it->second;
  report_unknown(node, name, what, keys_of(known));
  return nullptr;
}

}  // namespace aprsim::scene
