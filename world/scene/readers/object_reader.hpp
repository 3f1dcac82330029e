#pragma once

#include <vector>

#include "world/base/yaml/yaml_reader.hpp"
#include "world/scene/model/scene.hpp"
#include "world/scene/readers/type_reader.hpp"

namespace aprsim::scene {

/// Where each free body stands in the file, for messages; same order as in the scene.
struct BodyNodes {
  std::vector<yaml::Node> trays, gears;
};

[[nodiscard]] Physics read_physics(const yaml::Node& node);

/// Reads tools, robots, cameras, conveyor, fixed, holders, floor, light curtain, trays and gears
/// into `scene`; types come from `types`.
[[nodiscard]] BodyNodes read_objects(const yaml::Map& keys, const Types& types, Scene& scene);

}  // namespace aprsim::scene
