#pragma once

#include <map>
#include <string>
#include <vector>

#include "world/base/yaml/yaml_reader.hpp"
#include "world/scene/model/parts.hpp"

/// Whether what a scene's types say makes sense; errors go to the nodes.
namespace aprsim::scene {

/// Sense of a gear type in itself.
void check_gear_type(const yaml::Node& node, const GearType& type);

/// Whether the corners are an outline: 3 to Outline::kMaxCorners of them, convex,
/// counter-clockwise, at least 0.1 mm apart.
[[nodiscard]] bool check_outline(const yaml::Node& node,
                                 const std::vector<Eigen::Vector2d>& corners);

/// The label's recess lies in the slab.
void check_label(const yaml::Node& node, const TrayType& type);

/// Pockets lie in the slab and apart from each other, and their gears fit them. One node a slot.
void check_tray_type(const std::vector<yaml::Node>& slot_nodes, const TrayType& type,
                     const std::map<std::string, GearType>& gears);

}  // namespace aprsim::scene
