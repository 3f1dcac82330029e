#pragma once

#include <string>
#include <vector>

#include "world/robot/trajectory/blended_segments.hpp"
#include "world/robot/trajectory/tool_line.hpp"

namespace aprsim::robot {

/// A turn about an axis fixed in B together with an advance along it.
struct ToolHelix {
  Eigen::Isometry3d X_BT_start = Eigen::Isometry3d::Identity();
  Eigen::Vector3d point_B = Eigen::Vector3d::Zero();       ///< on the axis
  Eigen::Vector3d direction_B = Eigen::Vector3d::UnitZ();  ///< unit vector
  double travel_m = 0, turn_rad = 0;

  [[nodiscard]] Eigen::Isometry3d at(double share) const;
  [[nodiscard]] double radius_m() const;
  [[nodiscard]] double length_m() const;  ///< of the tool point's way
};

/// Path of the tool in space: straight lines one after the other, rounded where they meet, or one
/// helix. The parameter is the chain's time s. Thread: any.
class ToolPath {
 public:
  /// Forgets everything; lines then start at this pose.
  void start(const Eigen::Isometry3d& X_BT);
  /// From where the path ends so far. `waypoint`: its number, for messages; 0 = the only one.
  void add_line(const ToolLine& line, double duration_s, int waypoint = 0);
  /// Rounds the corner behind line `corner`.
  void blend(std::size_t corner, double half_width_s) { chain_.blend(corner, half_width_s); }
  void make_helix(const ToolHelix& helix, double duration_s);

  [[nodiscard]] Eigen::Isometry3d at(double s) const;
  /// Magnitudes of the second derivatives [m/s^2, rad/s^2] of a tool that runs at full speed.
  struct Curvature {
    double trans = 0, rot = 0;
  };
  [[nodiscard]] Curvature curvature(double s) const;
  [[nodiscard]] const BlendedSegments& chain() const { return chain_; }
  [[nodiscard]] const Eigen::Isometry3d& end() const { return end_; }
  /// For messages: "43 % of the straight line", "12 % of the way to waypoint 3".
  [[nodiscard]] std::string place(double s) const;

 private:
  BlendedSegments chain_;
  std::vector<ToolLine> lines_;
  std::vector<int> waypoints_;
  ToolHelix helix_;
  bool is_helix_ = false;
  Eigen::Isometry3d start_ = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d end_ = Eigen::Isometry3d::Identity();
};

}  // namespace aprsim::robot
