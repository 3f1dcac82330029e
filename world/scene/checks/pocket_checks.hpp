#pragma once

#include "world/base/yaml/yaml_reader.hpp"
#include "world/scene/model/parts.hpp"

/// Whether the pockets of a tray make sense; errors go to the nodes of their slots.
namespace aprsim::scene {

/// Distance of a point from the nearest edge of the slab [m].
[[nodiscard]] double to_edge(const TrayType& type, const Eigen::Vector2d& p);

/// The pocket leaves a floor, and its mouth lies within the tray's top face.
void check_pocket_in_slab(const yaml::Node& node, const TrayType& type, const Slot& slot);

/// The mouths of two pockets are apart.
void check_pockets_apart(const yaml::Node& node, const Slot& other, const Slot& slot);

/// The gear's hub fits into the pocket, and its disc rests on the tray.
void check_gear_in_pocket(const yaml::Node& node, const Slot& slot, const GearType& gear);

}  // namespace aprsim::scene
