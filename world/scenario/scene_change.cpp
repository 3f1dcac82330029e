#include "world/scenario/scene_change.hpp"

#include <algorithm>

namespace aprsim::scenario {
namespace {

bool has_name(const Tree& body, const std::string& name) {
  if (body.kind != Tree::Kind::kMap) return body.scalar == name;
  const yaml::detail::Entry* entry = body.find("name");
  return entry != nullptr && entry->value.scalar == name;
}

bool erase_named(Tree& scene, const char* key, const std::string& name) {
  yaml::detail::Entry* bodies = scene.find(key);
  return bodies != nullptr && std::erase_if(bodies->value.items, [&](const Tree& body) {
                                return has_name(body, name);
                              }) > 0;
}

}  // namespace

Tree& child(Tree& map, const std::string& key) {
  map.kind = Tree::Kind::kMap;
  if (yaml::detail::Entry* entry = map.find(key)) return entry->value;
  map.entries.push_back({.key = key});
  return map.entries.back().value;
}

bool remove_body(Tree& scene, const std::string& name) {
  bool found = erase_named(scene, "trays", name) || erase_named(scene, "gears", name);
  for_each_tray(scene, [&](Tree& tray) {
    yaml::detail::Entry* gears = tray.find("gears");
    if (gears == nullptr) return;
    found |= std::erase_if(gears->value.entries, [&](const yaml::detail::Entry& gear) {
               return has_name(gear.value, name);
             }) > 0;
  });
  return found;
}

}  // namespace aprsim::scenario
