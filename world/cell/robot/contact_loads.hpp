#pragma once

#include <span>

#include "world/physics/contacts/arm_force.hpp"
#include "world/robot/servo/servo_arm.hpp"

/// Loads of contacts on an arm. W = world, B = the arm's base, R = the robot's frame.
namespace aprsim::world {

/// Joint torques of contact forces [Nm].
struct ExternalTorque {
  robot::JointVector all;   ///< of all contacts
  robot::JointVector load;  ///< of those of the gripper with gears and trays
};
/// tau = J^T f. `X_WL`: poses of the links. Without a tool, forces on the gripper load nothing.
/// Does not allocate.
[[nodiscard]] ExternalTorque external_torque(const robot::ServoArm& arm,
                                             const Eigen::Isometry3d& X_WB,
                                             std::span<const Eigen::Isometry3d> X_WL,
                                             std::span<const physics::ArmForce> forces,
                                             bool has_tool);

/// Contact wrench on flange and tool about the tool point, in R.
struct ToolWrench {
  Eigen::Vector3d force_R = Eigen::Vector3d::Zero();   ///< [N]
  Eigen::Vector3d torque_R = Eigen::Vector3d::Zero();  ///< [Nm]
};
/// `flange`: index of the flange's link; `p_WT`: the tool point.
[[nodiscard]] ToolWrench tool_wrench(int flange, const Eigen::Isometry3d& X_WR,
                                     const Eigen::Vector3d& p_WT,
                                     std::span<const physics::ArmForce> forces, bool has_tool);

}  // namespace aprsim::world
