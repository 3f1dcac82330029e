#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "world/scene/yaml_reader.hpp"

namespace aprsim::server {

/// How one robot's CRCL port behaves where existing servers differ.
struct CrclRobotConfig {
  std::string length_unit = "millimeter";  ///< of a new socket: meter, millimeter or inch
  std::string angle_unit = "degree";       ///< of a new socket: degree or radian
  bool strict = false;         ///< `validation: strict`: what the schema does not allow is refused
  bool clamp_targets = false;  ///< `out_of_range: clamp`: targets are moved onto the limits
  /// Where the tool point may be sent, in the robot's reference frame [m]; its reach when absent.
  std::optional<std::array<double, 3>> cartesian_min_m, cartesian_max_m;
};

inline constexpr std::int64_t kMaxPort = 65535;

struct CrclConfig {
  std::string address = "127.0.0.1";
  /// By robot name; a robot that is not listed gets a free port.
  std::map<std::string, std::uint16_t> ports = {{"fanuc", 64444}, {"motoman", 64445}};
  std::uint32_t max_connections = 64;             ///< of each robot
  CrclRobotConfig all;                            ///< what holds for a robot that says nothing else
  std::map<std::string, CrclRobotConfig> robots;  ///< by name, complete

  [[nodiscard]] const CrclRobotConfig& of(const std::string& robot) const {
    const auto own = robots.find(robot);
    return own == robots.end() ? all : own->second;
  }
};

void read(const yaml::Node& node, CrclConfig& crcl);
[[nodiscard]] std::string to_yaml(const CrclConfig& crcl);

}  // namespace aprsim::server
