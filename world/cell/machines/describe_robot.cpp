#include "world/cell/machines/describe_robot.hpp"

#include "world/cell/machines/describe_gripper.hpp"
#include "world/robot/model/joint_rotation.hpp"
#include "world/scene/model/tool.hpp"

namespace aprsim::world {
namespace {

/// Bound of the tool point's distance from axis 1 at the height of axis 2: the sum of the lengths
/// from the second joint on, and the radius of the circle on which the first joint moves that one.
double reach_of(const robot::ArmModel& model, const Eigen::Isometry3d& X_FT) {
  double reach = X_FT.translation().norm() + robot::flange_offset(model);
  for (std::size_t i = 2; i < model.joints.size(); ++i) {
    reach += robot::longest_offset(model.joints[i]);
  }
  return reach + model.joints[1].X_PJ.translation().head<2>().norm();
}

/// Whether the first joint turns about z and the second one turns, as that bound takes it.
bool turns_upright(const robot::ArmModel& model) {
  const robot::Joint& first = model.joints[0];
  return !first.prismatic && !model.joints[1].prismatic && first.axis.head<2>().norm() < 1e-9;
}

/// A box about the point on axis 1 at the height of axis 2.
void describe_reach(const scene::Robot& robot, const robot::ArmModel& model,
                    api::RobotDescription& out) {
  const Eigen::Isometry3d X_RB = robot.X_BR.isometry().inverse();
  const auto& joints = model.joints;
  Eigen::Vector3d centre_B = joints[0].X_PJ.translation();
  double distance = reach_of(model, robot.tool_point_F.value_or(robot.X_FT).isometry());
  if (turns_upright(model)) {
    const Eigen::Vector3d upwards = joints[0].X_PJ.linear() * Eigen::Vector3d::UnitZ();
    centre_B += joints[1].X_PJ.translation().z() * upwards;
  } else {
    distance += robot::longest_offset(joints[0]) - joints[0].X_PJ.translation().norm() +
                robot::longest_offset(joints[1]);
  }
  const Eigen::Vector3d reach = Eigen::Vector3d::Constant(distance);
  out.reach_min_R = X_RB * centre_B - reach;
  out.reach_max_R = X_RB * centre_B + reach;
}

}  // namespace

api::RobotDescription describe_robot(const scene::Robot& robot, const robot::ArmModel& model) {
  api::RobotDescription out;
  out.name = robot.name;
  out.model = model.name;
  for (const auto& joint : model.joints) {
    out.joints.push_back({.name = joint.name,
                          .lower_rad = joint.lower_rad,
                          .upper_rad = joint.upper_rad,
                          .max_speed_rad_s = joint.max_speed_rad_s,
                          .max_torque_nm = joint.max_torque_nm,
                          .prismatic = joint.prismatic});
  }
  for (const auto& link : model.links) out.links.push_back(link.name);
  describe_reach(robot, model, out);
  out.X_WB = robot.X_WB;
  out.X_BR = robot.X_BR;
  out.X_RV = robot.vision.X_RV;
  out.X_FT = robot.X_FT;
  out.tool_point_F = robot.tool_point_F;
  out.wire_joints = robot.crcl_joints;
  out.clamps_targets = robot.clamps_targets;
  out.X_FQ = scene::coupling_of(robot);
  out.gripper = describe_gripper(robot.gripper);
  out.gripper.names = robot.gripper_names;
  out.max_trans_speed_m_s = robot.max_trans_speed_m_s;
  out.max_trans_accel_m_s2 = robot.max_trans_accel_m_s2;
  out.max_rot_speed_rad_s = robot.max_rot_speed_rad_s;
  out.max_rot_accel_rad_s2 = robot.max_rot_accel_rad_s2;
  return out;
}

}  // namespace aprsim::world
