#pragma once

#include "world/base/yaml/yaml_reader.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::scene {

/// Reads the list of Modbus servers, after all that has signals. Signals of devices are checked
/// where the devices are made. Errors go to the nodes.
void read_modbus_servers(const yaml::Node& node, Scene& scene);

}  // namespace aprsim::scene
