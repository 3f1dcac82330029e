#pragma once

#include <span>
#include <string>

#include "world/api/description/cell_description.hpp"
#include "world/physics/contacts/arm_force.hpp"
#include "world/physics/gripper/gripper_state.hpp"
#include "world/robot/servo/servo_arm.hpp"

namespace aprsim::world {

/// The operator's message of a collision that calls for a protective stop: a drive has tripped, or
/// the gripper's compliant mount is deflected beyond its limit. Empty: none does. `cell` names the
/// forces' partners.
[[nodiscard]] std::string collision_message(const robot::ServoArm& arm,
                                            const physics::GripperState& gripper, bool has_tool,
                                            std::span<const physics::ArmForce> forces,
                                            const api::CellDescription& cell);

}  // namespace aprsim::world
