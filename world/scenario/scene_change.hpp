#pragma once

#include <string>

#include "world/base/yaml/yaml_tree.hpp"

/// Edits of a scene's YAML tree by name. The text has been read as a valid scene before.
namespace aprsim::scenario {

using Tree = yaml::detail::Value;

/// The value under a key of a map; creates it if absent.
[[nodiscard]] Tree& child(Tree& map, const std::string& key);

/// Removes a gear, or a tray with its gears. False if the name is unknown.
[[nodiscard]] bool remove_body(Tree& scene, const std::string& name);

/// Calls `change` with the map of each tray.
template <typename Change>
void for_each_tray(Tree& scene, const Change& change) {
  yaml::detail::Entry* trays = scene.find("trays");
  if (trays == nullptr) return;
  for (Tree& tray : trays->value.items) change(tray);
}

}  // namespace aprsim::scenario
