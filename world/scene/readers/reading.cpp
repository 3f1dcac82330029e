#include "world/scene/readers/reading.hpp"

#include <algorithm>
#include <cctype>
#include <numbers>

namespace aprsim::scene {

double radians(double degrees) { return degrees * (std::numbers::pi / 180); }

Eigen::Vector2d read_xy(const yaml::Node& node) {
  const auto values = node.numbers<2>(yaml::between(-kFar, kFar));
  return {values[0], values[1]};
}

Eigen::Vector3d read_xyz(const yaml::Node& node, const yaml::Range& range) {
  const auto values = node.numbers<3>(range);
  return {values[0], values[1], values[2]};
}

Pose read_pose(const yaml::Node& xyz_m, const yaml::Node& rpy_deg) {
  Pose pose;
  pose.p = read_xyz(xyz_m);
  if (!rpy_deg) return pose;
  const Eigen::Vector3d rpy = read_xyz(rpy_deg, yaml::between(-360, 360));
  pose.q = Eigen::AngleAxisd(radians(rpy.z()), Eigen::Vector3d::UnitZ()) *
           Eigen::AngleAxisd(radians(rpy.y()), Eigen::Vector3d::UnitY()) *
           Eigen::AngleAxisd(radians(rpy.x()), Eigen::Vector3d::UnitX());
  return pose;
}

Pose read_pose_map(const yaml::Node& node) {
  if (!node) return {};
  const yaml::Map map = node.map({"xyz_m", "rpy_deg"});
  return read_pose(map["xyz_m"], map["rpy_deg"]);
}

void check_name(const yaml::Node& node, const std::string& name) {
  const auto allowed = [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '-' || c == '.';
  };
  if (name.size() > 64 || !std::all_of(name.begin(), name.end(), allowed)) {
    node.error('"' + name + '"', "a name of at most 64 letters, digits, '_', '-' and '.'");
  }
  // The frame that all poses are in has this name, in exports, too.
  if (name == "world")
    node.error("\"world\"", "another name, as \"world\" is the cell's own frame");
}

std::string read_name(const yaml::Node& node) {
  std::string name = node.text();
  check_name(node, name);
  return name;
}

std::string place_of(const yaml::Node& node) {
  const std::string where = node.where();
  const std::size_t column = where.rfind(':');
  const std::size_t line = column == 0 ? 0 : where.rfind(':', column - 1);
  return where.substr(line + 1) + ": " + node.key();
}

void report_unknown(const yaml::Node& node, const std::string& name, const std::string& what,
                    const std::vector<std::string>& known) {
  std::string list;
  for (const std::string& word : known) list += (list.empty() ? "" : ", ") + word;
  const std::string near = yaml::nearest_word(name, known);
  node.error("no " + what + " \"" + name + '"',
             (list.empty() ? "one that is defined (there is none)" : "one of " + list) +
                 (near.empty() ? "" : " (did you mean " + near + "?)"),
             ErrorCode::kNotFound);
}

}  // namespace aprsim::scene
