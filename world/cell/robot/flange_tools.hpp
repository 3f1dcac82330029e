#pragma once

#include <span>
#include <vector>

#include "world/robot/controller/controller_setup.hpp"
#include "world/scene/model/robot.hpp"
#include "world/scene/model/tool.hpp"

namespace aprsim::world {

/// A tool that no robot has, where it is.
struct LooseTool {
  int tool = 0;  ///< index among the scene's
  Eigen::Isometry3d X_WT = Eigen::Isometry3d::Identity();
};

/// The scene's tools as one robot's flange takes them. A tool of -1 is none. Immutable. Frames: F
/// flange, Q coupling, T tool, M mount of the tool, which is at F once the tool is drawn in.
class FlangeTools {
 public:
  FlangeTools(const scene::Robot& robot, std::span<const scene::Tool> tools);

  /// For the robot's controller, by tool.
  [[nodiscard]] std::vector<robot::ToolSetup> setups() const;
  [[nodiscard]] const robot::Payload& payload(int tool) const {
    return tool < 0 ? payload_open_ : at(tool).setup.payload;
  }
  /// Force of each finger at the supply's full pressure; without a tool that of the robot's own
  /// gripper.
  [[nodiscard]] double full_grip_force_n(int tool) const {
    return tool < 0 ? own_grip_force_n_ : at(tool).grip_force_n;
  }
  /// The nearest of the tools whose coupling is within the capture range of a flange at `X_WF`; -1
  /// = none.
  [[nodiscard]] int within_capture(const Eigen::Isometry3d& X_WF,
                                   std::span<const LooseTool> loose) const;
  /// Pose of this flange's mount if the tool were on it, at its present place.
  [[nodiscard]] Eigen::Isometry3d mount_of(const LooseTool& loose) const {
    return loose.X_WT * at(loose.tool).X_FT.inverse();
  }

 private:
  struct Entry {
    Eigen::Isometry3d X_FT, X_TQ;
    robot::ToolSetup setup;
    double grip_force_n;
  };
  [[nodiscard]] const Entry& at(int tool) const { return tools_[static_cast<std::size_t>(tool)]; }

  std::vector<Entry> tools_;
  robot::Payload payload_open_;
  double own_grip_force_n_;
  Eigen::Isometry3d X_FQ_;
  double capture_m_, capture_rad_;
};

}  // namespace aprsim::world
