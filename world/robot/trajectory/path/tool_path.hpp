#pragma once

#include <string>
#include <vector>

#include "world/robot/trajectory/path/blended_segments.hpp"
#include "world/robot/trajectory/path/tool_line.hpp"

namespace aprsim::robot {

/// A helix: a turn about an axis fixed in B with an advance along it.
struct ToolHelix {
  Eigen::Isometry3d X_BT_start = Eigen::Isometry3d::Identity();
  Eigen::Vector3d point_B = Eigen::Vector3d::Zero();       ///< on the axis
  Eigen::Vector3d direction_B = Eigen::Vector3d::UnitZ();  ///< unit vector
  double travel_m = 0, turn_rad = 0;

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [X_BT_start, point_B, direction_B, travel_m, turn_rad] = self;
    io(X_BT_start, point_B, direction_B, travel_m, turn_rad);
  }

  [[nodiscard]] Eigen::Isometry3d at(double share) const;
  [[nodiscard]] double radius_m() const;
  [[nodiscard]] double length_m() const;  ///< of the tool point's path
};

/// Path of the tool in space: straight lines, blended at the corners, or one helix. The parameter
/// is the time s of its segments. Thread: any.
class ToolPath {
 public:
  /// Clears the path; lines then start at this pose.
  void start(const Eigen::Isometry3d& X_BT);
  /// From the path's end so far. `waypoint`: its number, for messages; 0 = the only one.
  void add_line(const ToolLine& line, double duration_s, int waypoint = 0);
  /// Blends the corner behind line `corner`.
  void blend(std::size_t corner, double half_width_s) { segments_.blend(corner, half_width_s); }
  void make_helix(const ToolHelix& helix, double duration_s);

  [[nodiscard]] Eigen::Isometry3d at(double s) const;
  /// Magnitudes of the second derivatives [m/s^2, rad/s^2] of a tool that runs at full speed.
  struct Curvature {
    double trans = 0, rot = 0;
  };
  [[nodiscard]] Curvature curvature(double s) const;
  [[nodiscard]] const BlendedSegments& segments() const { return segments_; }
  /// Whether at() can be called.
  [[nodiscard]] bool is_complete() const {
    const std::size_t count = segments_.size();
    if (is_helix_) return count == 1;
    return count > 0 && lines_.size() == count && waypoints_.size() == count;
  }
  [[nodiscard]] const Eigen::Isometry3d& end() const { return end_; }
  /// For messages: "43 % of the straight line", "12 % of the way to waypoint 3".
  [[nodiscard]] std::string describe_position(double s) const;
  /// Allocated memory, besides the value itself.
  [[nodiscard]] std::size_t bytes() const {
    return segments_.bytes() + bytes_of(lines_) + bytes_of(waypoints_);
  }

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [segments, lines, waypoints, helix, is_helix, start, end] = self;
    io(segments, lines, waypoints, helix, is_helix, start, end);
  }

 private:
  BlendedSegments segments_;
  std::vector<ToolLine> lines_;
  std::vector<int> waypoints_;
  ToolHelix helix_;
  bool is_helix_ = false;
  Eigen::Isometry3d start_ = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d end_ = Eigen::Isometry3d::Identity();
};

}  // namespace aprsim::robot
