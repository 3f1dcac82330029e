#pragma once

#include "world/physics/model/physics_model.hpp"

/// Effect of a tool changer on the bodies, between two steps: a tool is either a free body or the
/// mechanism on a robot's flange.
namespace aprsim::physics {

/// Attaches a free tool to a robot without one, with its mount at `X_WF`.
void attach_tool(PhysicsModel& model, int robot, int tool, const Eigen::Isometry3d& X_WF);

/// Detaches the robot's tool, if it has one: it becomes a free body with its mount's velocity.
void detach_tool(PhysicsModel& model, int robot);

/// Moves every mechanism to the flange or rack that it has with these tools on the robots.
void arrange_tools(PhysicsModel& model, const std::vector<int>& tool_of_robot);

}  // namespace aprsim::physics
