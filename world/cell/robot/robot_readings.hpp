#pragma once

#include "world/api/snapshot/robot_snapshot.hpp"
#include "world/physics/gripper/gripper_state.hpp"
#include "world/robot/controller/robot_controller.hpp"
#include "world/robot/servo/servo_arm.hpp"

/// Parts of a robot's snapshot, each from what it shows. Does not allocate, except for long
/// descriptions. Thread: sim.
namespace aprsim::world {

/// Joints, and the tool's pose and velocity in R. Goes through the base and not the world: a pose
/// that a client compares must not depend on the cell's layout.
void write_motion(const robot::ServoArm& arm, const Eigen::Isometry3d& X_BR,
                  const Eigen::Isometry3d& X_FT, api::RobotSnapshot& out);

/// `max_force_n`: of each finger at the pressure that is set.
[[nodiscard]] api::GripperSnapshot gripper_readings(const physics::GripperState& gripper,
                                                    double setting, double max_force_n);

/// Limits, the command's progress and goal, and the controller's mode.
void write_controller(const robot::RobotController& controller, api::RobotSnapshot& out);

}  // namespace aprsim::world
