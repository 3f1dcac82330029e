#pragma once

#include <string>
#include <vector>

#include "world/base/yaml/yaml_reader.hpp"
#include "world/scene/model/scene.hpp"

/// Parts and fixtures, which consist of convex pieces.
namespace aprsim::scene {

inline constexpr std::size_t kMaxPieces = 32;  ///< of a part or fixture

[[nodiscard]] PartType read_part_type(const yaml::Node& node, const std::string& name);

/// A fixture without its name. `keys`: pieces, material, xyz_m, rpy_deg.
[[nodiscard]] Fixture read_fixture(const yaml::Map& keys);

/// The list physics.materials.
[[nodiscard]] std::vector<MaterialPair> read_material_pairs(const yaml::Node& node);

/// Reports a pair of physics.materials with a material that nothing in the scene has.
void check_materials(const yaml::Node& node, const Scene& scene);

}  // namespace aprsim::scene
