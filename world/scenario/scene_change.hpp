#pragma once

#include <string>

#include "world/base/yaml/yaml_tree.hpp"

/// Changes of a scene's text, by the names of its things. A scene has been read from it before.
namespace aprsim::scenario {

using Tree = yaml::detail::Value;

/// The value under a key of a map, made when there is none.
[[nodiscard]] Tree& child(Tree& map, const std::string& key);

/// Takes a tray with its gears, or a gear, out. False when there is none of this name.
[[nodiscard]] bool remove_body(Tree& scene, const std::string& name);

/// Calls `change` with each tray, a map.
template <typename Change>
void for_each_tray(Tree& scene, const Change& change) {
  yaml::detail::Entry* trays = scene.find("trays");
  if (trays == nullptr) return;
  for (Tree& tray : trays->value.items) change(tray);
}

}  // namespace aprsim::scenario
