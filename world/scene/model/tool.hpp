#pragma once

#include <string>
#include <vector>

#include "world/api/values/pose.hpp"
#include "world/scene/model/robot.hpp"

/// Tools that robots take and leave by their tool changers. SI. Frames: F flange, Q the coupling
/// plane of changer and tool, z along the approach, T tool.
namespace aprsim::scene {

struct Scene;

struct Tool {
  std::string name;
  Gripper gripper;
  /// Between the finger tips, z along the approach, fingers move along y; of a cup in its lip.
  Pose X_QT;
  Pose X_WQ;  ///< where its coupling is at the start, when no robot has it
  /// Its robot has it from its type; the scene does not list it.
  bool own = false;
};

/// The coupling in a robot's flange; without one in the scene at the flange, turned as its tool.
[[nodiscard]] Pose coupling_of(const Robot& robot);

/// Those that the scene lists, then one for each robot that has no tool from that list.
[[nodiscard]] std::vector<Tool> tools_of(const Scene& scene);

/// The tool on each robot's flange at the start: its index, -1 = none.
[[nodiscard]] std::vector<int> tools_at_start(const Scene& scene);

}  // namespace aprsim::scene
