#pragma once

#include <string>
#include <vector>

#include "world/scene/model/scene.hpp"

namespace aprsim::client {

/// Names of gears and parts whose top no robot reaches with its tool point, approach downwards and
/// at any of 16 yaws; obstacles are not regarded. Robots whose model has no inverse kinematics are
/// left out; without any robot, the list is empty.
[[nodiscard]] std::vector<std::string> bodies_out_of_reach(const scene::Scene& scene);

}  // namespace aprsim::client
