#pragma once

#include "world/base/yaml/yaml_reader.hpp"
#include "world/scene/model/vision.hpp"

namespace aprsim::scene {

/// From a robot's key "vision"; what is absent keeps its default. The camera hangs 2 m above the
/// middle of the area's +x edge unless told otherwise: before the robot it looks past the arm.
[[nodiscard]] Vision read_vision(const yaml::Node& node);

}  // namespace aprsim::scene
