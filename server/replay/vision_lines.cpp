#include "server/replay/vision_lines.hpp"

#include <functional>

#include "protocols/vision/vision_line.hpp"

namespace aprsim::server::journal {

void VisionLines::add(const api::Snapshot& snapshot) {
  for (std::size_t robot = 0; robot < snapshot.robots.size(); ++robot) {
    Camera& camera = cameras_[snapshot.cell->robots[robot].name];
    const api::VisionFrame& frame = snapshot.robots[robot].vision;
    if (camera.cell == snapshot.cell && camera.epoch == snapshot.epoch &&
        camera.frame == frame.number) {
      continue;
    }
    camera.cell = snapshot.cell;
    camera.epoch = snapshot.epoch;
    camera.frame = frame.number;
    for (const bool empty_slots : {false, true}) {
      camera.lines.insert(
          std::hash<std::string>()(vision_server::vision_line(frame, *snapshot.cell, empty_slots)));
    }
  }
}

bool VisionLines::has(const std::string& robot, const std::string& line) const {
  const auto camera = cameras_.find(robot);
  return camera != cameras_.end() && camera->second.lines.contains(std::hash<std::string>()(line));
}

}  // namespace aprsim::server::journal
