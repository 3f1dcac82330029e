#pragma once

#include "world/robot/kinematics/dynamics.hpp"
#include "world/scene/model/robot.hpp"

/// Payloads on a robot's flange. F = flange, T = tool.
namespace aprsim::world {

/// Payload of a gripper: mount, palm and fingers as one box around the palm's centre, which is
/// behind the finger pads.
[[nodiscard]] robot::Payload gripper_payload(const scene::Gripper& gripper,
                                             const Eigen::Isometry3d& X_FT);

/// Payload of the tool changer's plate, which stays on the flange: a point mass halfway to its
/// coupling.
[[nodiscard]] robot::Payload changer_payload(const scene::Robot& robot);

/// Both as one rigid body.
[[nodiscard]] robot::Payload joined(const robot::Payload& a, const robot::Payload& b);

}  // namespace aprsim::world
