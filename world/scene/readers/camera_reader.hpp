#pragma once

#include "world/base/yaml/yaml_reader.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::scene {

/// The key cameras, a list; after the robots, whose names its entries may give.
void read_cameras(const yaml::Node& node, Scene& scene);

}  // namespace aprsim::scene
