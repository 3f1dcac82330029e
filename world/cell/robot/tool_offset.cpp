#include "world/cell/robot/tool_offset.hpp"

namespace aprsim::world {

api::RobotAction ToolOffset::displaced(api::RobotAction action) const {
  if (auto* to = std::get_if<api::MoveTo>(&action)) {
    to->X_RT = displaced(to->X_RT);
  } else if (auto* through = std::get_if<api::MoveThroughTo>(&action)) {
    for (api::Waypoint& point : through->waypoints) point.X_RT = displaced(point.X_RT);
  } else if (auto* screw = std::get_if<api::MoveScrew>(&action)) {
    if (screw->start) screw->start->X_RT = displaced(screw->start->X_RT);
    if (screw->axis_point_R) screw->axis_point_R = base_ * *screw->axis_point_R;
  }
  return action;
}

}  // namespace aprsim::world
