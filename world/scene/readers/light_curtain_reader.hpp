#pragma once

#include "world/base/yaml/yaml_reader.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::scene {

/// Reads the key light_curtain into `scene`, whose fixed things and conveyor have been read. A beam
/// that one of those or the floor interrupts is an error: the curtain would never be clear.
void read_light_curtain(const yaml::Node& node, Scene& scene);

}  // namespace aprsim::scene
