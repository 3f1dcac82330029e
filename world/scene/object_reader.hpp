#pragma once

#include <vector>

#include "world/scene/scene.hpp"
#include "world/scene/type_reader.hpp"
#include "world/scene/yaml_reader.hpp"

namespace aprsim::scene {

/// Where each free body stands in the file, for messages; same order as in the scene.
struct BodyNodes {
  std::vector<yaml::Node> trays, gears;
};

[[nodiscard]] Physics read_physics(const yaml::Node& node);

/// Reads robots, conveyor, fixed, floor, light curtain, trays and gears into `scene`; types come
/// from `types`.
[[nodiscard]] BodyNodes read_objects(const yaml::Map& keys, const Types& types, Scene& scene);

/// Records an error for the first free body that lies more than 0.1 mm deep in something: tray or
/// gear in another, in a fixed box, the belt or the floor. A gear and its own tray are left out.
void check_overlaps(const Scene& scene, const BodyNodes& nodes);

}  // namespace aprsim::scene
