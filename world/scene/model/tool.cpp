#include "world/scene/model/tool.hpp"

#include <algorithm>

#include "world/scene/model/scene.hpp"

namespace aprsim::scene {

Pose coupling_of(const Robot& robot) {
  return robot.changer.X_FQ.value_or(Pose{Eigen::Vector3d::Zero(), robot.X_FT.q});
}

std::vector<Tool> tools_of(const Scene& scene) {
  std::vector<Tool> tools = scene.tools;
  for (const Robot& robot : scene.robots) {
    if (robot.tool) continue;
    Tool own;
    own.name = robot.name + "_gripper";
    own.gripper = robot.gripper;
    own.X_QT = Pose::from(coupling_of(robot).isometry().inverse() * robot.X_FT.isometry());
    own.own = true;
    tools.push_back(std::move(own));
  }
  return tools;
}

std::vector<int> tools_at_start(const Scene& scene) {
  std::vector<int> start;
  int own = static_cast<int>(scene.tools.size());
  for (const Robot& robot : scene.robots) {
    if (!robot.tool) {
      start.push_back(own++);
      continue;
    }
    const auto it = std::find_if(scene.tools.begin(), scene.tools.end(),
                                 [&](const Tool& tool) { return tool.name == *robot.tool; });
    start.push_back(it == scene.tools.end() ? -1 : static_cast<int>(it - scene.tools.begin()));
  }
  return start;
}

}  // namespace aprsim::scene
