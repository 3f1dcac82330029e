#pragma once

#include "world/api/description/cell_description.hpp"
#include "world/robot/model/arm_model.hpp"
#include "world/scene/model/robot.hpp"

namespace aprsim::world {

/// The constants of a robot that clients see.
[[nodiscard]] api::RobotDescription describe_robot(const scene::Robot& robot,
                                                   const robot::ArmModel& model);

}  // namespace aprsim::world
