#pragma once

#include <map>
#include <string>
#include <vector>

#include "world/base/yaml/yaml_reader.hpp"
#include "world/scene/files/file_scope.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::scene {

/// Types of a scene's objects, from the scene's own file and the files it names.
struct Types {
  std::map<std::string, Pocket> pockets;
  std::map<std::string, GearType> gears;
  std::map<std::string, TrayType> trays;
  std::map<std::string, PartType> parts;
  std::map<std::string, Robot> robots;  ///< with neither name nor place
};

/// Adds the types under the keys pockets, gear_types, tray_types, part_types and robot_types of
/// `keys`. `scope` finds the models of robots.
void read_types(const yaml::Map& keys, const FileScope& scope, Types& types);

/// A parallel gripper, as robot types and tools have it.
[[nodiscard]] Gripper read_gripper(const yaml::Node& node);

/// Joint angles [rad] from a list in degrees.
[[nodiscard]] std::vector<double> read_joints(const yaml::Node& node);

}  // namespace aprsim::scene
