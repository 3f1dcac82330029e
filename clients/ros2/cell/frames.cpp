#include "clients/ros2/cell/frames.hpp"

#include <algorithm>

#include "clients/ros2/cell/names.hpp"

namespace aprsim::ros2 {

std::vector<Frame> fixed_frames(const v1::CellDescription& cell) {
  std::vector<Frame> frames;
  for (const auto& robot : cell.robots()) {
    frames.push_back({ros_token(robot.name()) + "_base", robot.base_in_world()});
  }
  for (const auto& camera : cell.cameras()) {
    if (!camera.has_camera_in_world()) continue;
    frames.push_back({ros_token(camera.name()) + "_optical_frame", camera.camera_in_world()});
  }
  return frames;
}

std::vector<Frame> moving_frames(const v1::CellDescription& cell, const v1::Snapshot& snapshot) {
  std::vector<Frame> frames;
  for (const auto& robot : snapshot.robots()) {
    frames.push_back({ros_token(robot.name()) + "_tool", robot.tool_in_world()});
  }
  for (const auto& body : snapshot.bodies()) {
    if (!body.has_lost_step()) frames.push_back({ros_token(body.name()), body.body_in_world()});
  }
  for (int i = 0; i < std::min(cell.tools_size(), snapshot.tools_size()); ++i) {
    const auto& tool = snapshot.tools(i);
    if (!cell.tools(i).listed() || tool.has_lost_step()) continue;
    frames.push_back({ros_token(tool.name()), tool.tool_in_world()});
  }
  return frames;
}

}  // namespace aprsim::ros2
