#include "world/robot/trajectory/path/tool_path.hpp"

#include <cmath>
#include <cstdio>

namespace aprsim::robot {

Eigen::Isometry3d ToolHelix::at(double share) const {
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(share * turn_rad, direction_B).toRotationMatrix();
  Eigen::Isometry3d X_BT;
  X_BT.linear() = turn * X_BT_start.linear();
  X_BT.translation() =
      // Screw motion (Chasles): rotation about an axis with a translation along it, both in
      // proportion.
      point_B + turn * (X_BT_start.translation() - point_B) + share * travel_m * direction_B;
  return X_BT;
}

double ToolHelix::radius_m() const {
  const Eigen::Vector3d arm = X_BT_start.translation() - point_B;
  return (arm - arm.dot(direction_B) * direction_B).norm();
}

double ToolHelix::length_m() const { return std::hypot(travel_m, radius_m() * turn_rad); }

void ToolPath::start(const Eigen::Isometry3d& X_BT) {
  segments_.clear();
  lines_.clear();
  waypoints_.clear();
  is_helix_ = false;
  start_ = end_ = X_BT;
}

void ToolPath::add_line(const ToolLine& line, double duration_s, int waypoint) {
  lines_.push_back(line);
  waypoints_.push_back(waypoint);
  segments_.add(duration_s);
  end_ = line.end();
}

void ToolPath::make_helix(const ToolHelix& helix, double duration_s) {
  start(helix.X_BT_start);
  helix_ = helix;
  is_helix_ = true;
  end_ = helix.at(1);
  segments_.add(duration_s);
}

Eigen::Isometry3d ToolPath::at(double s) const {
  if (s >= segments_.length()) return end_;
  if (is_helix_) return helix_.at(segments_.share(0, s));
  // In a blend two lines are under way: one ends while the other begins.
  // Superposition of the lines under way, each with its share; rotations in their order.
  const auto [first, last] = segments_.active(s);
  Eigen::Isometry3d X_BT = lines_[first].at(segments_.share(first, s));
  for (std::size_t i = first + 1; i <= last; ++i) {
    const double share = segments_.share(i, s);
    X_BT.translation() += share * lines_[i].shift();
    X_BT.linear() = X_BT.linear() * lines_[i].turn(share);
  }
  return X_BT;
}

ToolPath::Curvature ToolPath::curvature(double s) const {
  // A helix turns at constant speed: centripetal acceleration only.
  if (is_helix_) {
    const double turn_rate = helix_.turn_rad * segments_.rate(0, s);
    return {helix_.radius_m() * turn_rate * turn_rate, 0};
  }
  // Lines curve in their blends only; the change of the axes in a blend is left out.
  const auto [first, last] = segments_.active(s);
  Eigen::Vector3d trans = Eigen::Vector3d::Zero(), rot = trans;
  for (std::size_t i = first; i <= last; ++i) {
    const double curvature = segments_.curvature(i, s);
    trans += curvature * lines_[i].shift();
    rot += curvature * lines_[i].turn_vector_B();
  }
  return {trans.norm(), rot.norm()};
}

std::string ToolPath::describe_position(double s) const {
  const auto [first, last] = segments_.active(s);
  const std::size_t i = last > first && s >= segments_.begin(last) ? last : first;
  const double percent = 100 * (s - segments_.begin(i)) / segments_.duration(i);
  char text[80];
  if (is_helix_) {
    std::snprintf(text, sizeof text, "%.0f %% of the screw", percent);
  } else if (waypoints_[i] == 0) {
    std::snprintf(text, sizeof text, "%.0f %% of the straight line", percent);
  } else {
    std::snprintf(text, sizeof text, "%.0f %% of the straight line to waypoint %d", percent,
                  waypoints_[i]);
  }
  return text;
}

}  // namespace aprsim::robot
