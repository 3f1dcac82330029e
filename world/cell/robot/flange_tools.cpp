#include "world/cell/robot/flange_tools.hpp"

#include "world/cell/robot/tool_payload.hpp"

namespace aprsim::world {

FlangeTools::FlangeTools(const scene::Robot& robot, std::span<const scene::Tool> tools)
    : payload_open_(changer_payload(robot)),
      own_grip_force_n_(robot.gripper.force_n),
      X_FQ_(scene::coupling_of(robot).isometry()),
      capture_m_(robot.changer.capture_m),
      capture_rad_(robot.changer.capture_rad) {
  for (const scene::Tool& tool : tools) {
    const Eigen::Isometry3d X_QT = tool.X_QT.isometry();
    const Eigen::Isometry3d X_FT = X_FQ_ * X_QT;
    tools_.push_back(
        {.X_FT = X_FT,
         .X_TQ = X_QT.inverse(),
         .setup = {.X_FT = robot.tool_point_F ? robot.tool_point_F->isometry() : X_FT,
                   .payload = joined(payload_open_, gripper_payload(tool.gripper, X_FT))},
         .grip_force_n = tool.gripper.force_n});
  }
}

std::vector<robot::ToolSetup> FlangeTools::setups() const {
  std::vector<robot::ToolSetup> out;
  for (const Entry& tool : tools_) out.push_back(tool.setup);
  return out;
}

int FlangeTools::within_capture(const Eigen::Isometry3d& X_WF,
                                std::span<const LooseTool> loose) const {
  int nearest = -1;
  double least = capture_m_;
  const Eigen::Isometry3d X_QW = (X_WF * X_FQ_).inverse();
  for (const LooseTool& tool : loose) {
    const Eigen::Isometry3d off = X_QW * tool.X_WT * at(tool.tool).X_TQ;
    const double distance = off.translation().norm();
    if (distance > least || Eigen::AngleAxisd(off.linear()).angle() > capture_rad_) continue;
    least = distance;
    nearest = tool.tool;
  }
  return nearest;
}

}  // namespace aprsim::world
