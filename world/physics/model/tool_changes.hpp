#pragma once

#include "world/physics/model/physics_model.hpp"

/// Effect of a tool changer on the bodies, between two steps: a tool is either a free body or the
/// mechanism on a robot's flange.
namespace aprsim::physics {

/// A tool that no robot has becomes the gripper of a robot without one, its mount at `X_WF`.
void take_tool(PhysicsModel& model, int robot, int tool, const Eigen::Isometry3d& X_WF);

/// The robot's tool, if it has one, becomes a free body that moves on as its mount did.
void leave_tool(PhysicsModel& model, int robot);

/// Every mechanism to the flange, or the place, that it has when the robots' tools are these.
void arrange_tools(PhysicsModel& model, const std::vector<int>& tool_of_robot);

}  // namespace aprsim::physics
