#pragma once

#include "world/api/description/cell_description.hpp"
#include "world/scene/model/robot.hpp"

namespace aprsim::world {

/// The published description of a gripper, without further names.
[[nodiscard]] api::GripperDescription describe_gripper(const scene::Gripper& gripper);

}  // namespace aprsim::world
