#include "world/physics/model/tool_changes.hpp"

#include <utility>

namespace aprsim::physics {
namespace {

/// Exchanges the mechanism of the robot's empty flange with that of the tool.
void swap_mechanisms(PhysicsModel& model, int robot, int tool) {
  std::swap(model.grippers[static_cast<std::size_t>(robot)],
            model.parked[static_cast<std::size_t>(tool)]);
}

}  // namespace

void attach_tool(PhysicsModel& model, int robot, int tool, const Eigen::Isometry3d& X_WF) {
  const auto r = static_cast<std::size_t>(robot);
  const int index = model.ids.tool(tool);
  model.body(index).mounted = true;
  model.simplification.remove_mounted(index);
  swap_mechanisms(model, robot, tool);
  model.tool_of_robot[r] = tool;
  const Eigen::Isometry3d X_FQ = scene::coupling_of(model.scene.robots[r]).isometry();
  const Eigen::Isometry3d X_QT = model.tools[static_cast<std::size_t>(tool)].X_QT.isometry();
  model.grippers[r].attach(X_WF, X_FQ * X_QT);
}

void detach_tool(PhysicsModel& model, int robot) {
  const auto r = static_cast<std::size_t>(robot);
  const int tool = std::exchange(model.tool_of_robot[r], -1);
  if (tool < 0) return;
  GripperMechanism& gripper = model.grippers[r];
  const int index = model.ids.tool(tool);
  FreeBody& body = model.body(index);
  // Momentum is kept: the free tool has the velocity of its centre of mass as the mount moved it.
  // The real pose includes the mount's deflection.
  const Eigen::Isometry3d X_WT = gripper.state().X_WT.isometry();
  const Eigen::Vector3d v = gripper.mount_velocity(X_WT * body.mass.com);
  const Eigen::Vector3d omega = gripper.mount_omega();
  body.tool->set_opening(gripper.state().separation_m);
  gripper.detach();
  swap_mechanisms(model, robot, tool);
  body.mounted = false;
  body.place(X_WT, v, omega);
  model.simplification.add(index);
}

void arrange_tools(PhysicsModel& model, const std::vector<int>& tool_of_robot) {
  const auto swap_all = [&model](const std::vector<int>& tools) {
    for (std::size_t r = 0; r < tools.size(); ++r) {
      if (tools[r] >= 0) swap_mechanisms(model, static_cast<int>(r), tools[r]);
    }
  };
  swap_all(model.tool_of_robot);  // back
  swap_all(tool_of_robot);
  model.tool_of_robot = tool_of_robot;
}

}  // namespace aprsim::physics
