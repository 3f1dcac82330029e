#pragma once

#include <string>
#include <vector>

#include "world/api/values/pose.hpp"

/// Shapes of the cell for display only; SI units, fields as in aprsim.v1.CellAppearance.
namespace aprsim::web {

struct FixedBoxVisual {
  std::string name;
  Eigen::Vector3d size = Eigen::Vector3d::Zero();
  Pose X_WS;  ///< of its centre
};

struct RobotVisual {
  double pad_height_m = 0, pad_width_m = 0, pad_depth_m = 0;
  double v_half_angle_rad = 0;                          ///< 0 = flat pads
  Eigen::Vector3d palm_size = Eigen::Vector3d::Zero();  ///< in the tool frame
  Eigen::Vector3d camera_V = Eigen::Vector3d::Zero();
  Eigen::Vector2d area_min = Eigen::Vector2d::Zero(), area_max = Eigen::Vector2d::Zero();
};

struct GearVisual {
  std::string type;
  double hub_top_radius_m = 0, hub_bottom_radius_m = 0, hub_height_m = 0, teeth_radius_m = 0;
};

struct PocketVisual {
  double top_radius_m = 0, floor_radius_m = 0, depth_m = 0;
};

struct TrayVisual {
  std::string type;
  std::vector<PocketVisual> pockets;  ///< in the order of the tray's slots
};

struct VisualDescription {
  std::vector<FixedBoxVisual> fixed;
  std::vector<RobotVisual> robots;  ///< in the order of CellDescription::robots
  std::vector<GearVisual> gears;
  std::vector<TrayVisual> trays;
};

}  // namespace aprsim::web
