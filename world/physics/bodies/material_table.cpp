#include "world/physics/bodies/material_table.hpp"

#include <algorithm>

namespace aprsim::physics {
namespace {

using Table = MaterialTable;

/// The value of a pair that the scene does not list: a part is as a gear, a fixture as a fixed box.
double usual_value(const scene::SurfacePairs& property, int a, int b) {
  const auto has = [&](int usual) { return a == usual || b == usual; };
  if (has(Table::kRobot)) return property.robot;
  if (has(Table::kFixed) || has(Table::kBelt)) return property.gear_ground;
  return has(Table::kTray) ? property.gear_tray : property.gear_gear;
}

}  // namespace

MaterialTable::MaterialTable(const scene::Scene& scene)
    : names_{scene::kGearMaterial, scene::kTrayMaterial, scene::kFixedMaterial,
             scene::kBeltMaterial, scene::kRobotMaterial} {
  const auto add = [this](const std::string& name) {
    if (std::ranges::find(names_, name) == names_.end()) names_.push_back(name);
  };
  // A fixture's own material is as that of fixed boxes, where no pair is listed.
  std::vector<std::string> fixed{scene::kFixedMaterial};
  for (const auto& [name, type] : scene.part_types) add(type.material);
  for (const auto& fixture : scene.fixtures) {
    add(fixture.material);
    fixed.push_back(fixture.material);
  }
  const auto usual_of = [&](std::size_t i) {
    if (i < kUsual) return static_cast<int>(i);
    const bool is_fixed = std::ranges::find(fixed, names_[i]) != fixed.end();
    return static_cast<int>(is_fixed ? kFixed : kGear);
  };
  const scene::Physics& physics = scene.physics;
  for (std::size_t i = 0; i < names_.size(); ++i) {
    for (std::size_t k = 0; k < names_.size(); ++k) {
      const int a = usual_of(i), b = usual_of(k);
      pairs_.push_back({.friction = usual_value(physics.friction, a, b),
                        .restitution = usual_value(physics.restitution, a, b),
                        .rolling_m = usual_value(physics.rolling_m, a, b),
                        .spinning_m = usual_value(physics.spinning_m, a, b)});
    }
  }
  for (const scene::MaterialPair& pair : physics.materials) {
    const auto a = static_cast<std::size_t>(number_of(pair.a));
    const auto b = static_cast<std::size_t>(number_of(pair.b));
    const Surfaces given{pair.friction, pair.restitution, pair.rolling_m, pair.spinning_m};
    pairs_[a * names_.size() + b] = pairs_[b * names_.size() + a] = given;
  }
}

int MaterialTable::number_of(const std::string& material) const {
  const auto found = std::ranges::find(names_, material);
  return found == names_.end() ? kGear : static_cast<int>(found - names_.begin());
}

}  // namespace aprsim::physics
