#include "server/replay/vision_lines.hpp"

#include <functional>

#include "protocols/vision/vision_line.hpp"

namespace aprsim::server::journal {

void VisionLines::add(const api::Snapshot& snapshot) {
  cameras_.resize(snapshot.robots.size());
  for (std::size_t robot = 0; robot < cameras_.size(); ++robot) {
    Camera& camera = cameras_[robot];
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

bool VisionLines::has(std::size_t robot, const std::string& line) const {
  return robot < cameras_.size() && cameras_[robot].lines.contains(std::hash<std::string>()(line));
}

}  // namespace aprsim::server::journal
