#pragma once

#include "world/base/yaml/yaml_reader.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::scene {

/// Reads the list of devices. Errors go to the nodes.
void read_devices(const yaml::Node& node, Scene& scene);

}  // namespace aprsim::scene
