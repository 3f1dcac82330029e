#pragma once

#include "world/scene/vision.hpp"
#include "world/scene/yaml_reader.hpp"

namespace aprsim::scene {

/// From a robot's key "vision"; what is absent keeps its default.
[[nodiscard]] Vision read_vision(const yaml::Node& node);

}  // namespace aprsim::scene
