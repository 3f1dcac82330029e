#include "server/crcl_config.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "server/yaml_text.hpp"

namespace aprsim::server {
namespace {

std::optional<std::array<double, 3>> point(const yaml::Node& node) {
  if (!node) return std::nullopt;
  return node.numbers<3>();
}

/// What stands in `map`; the rest stays.
void read(const yaml::Map& map, CrclRobotConfig& robot) {
  if (const auto unit = map["length_unit"]) {
    const char* const names[] = {"meter", "millimeter", "inch"};
    robot.length_unit = names[unit.word({"meter", "millimeter", "inch"})];
  }
  if (const auto unit = map["angle_unit"]) {
    const char* const names[] = {"degree", "radian"};
    robot.angle_unit = names[unit.word({"degree", "radian"})];
  }
  if (const auto mode = map["validation"]) robot.strict = mode.word({"lenient", "strict"}) == 1;
  if (const auto mode = map["out_of_range"])
    robot.clamp_targets = mode.word({"refuse", "clamp"}) == 1;
  if (const auto min = point(map["cartesian_min_m"])) robot.cartesian_min_m = min;
  if (const auto max = point(map["cartesian_max_m"])) robot.cartesian_max_m = max;
  for (std::size_t i = 0; i < 3 && robot.cartesian_min_m && robot.cartesian_max_m; ++i) {
    if ((*robot.cartesian_min_m)[i] < (*robot.cartesian_max_m)[i]) continue;
    map.node().unexpected("cartesian_min_m below cartesian_max_m on every axis");
  }
}

std::string to_yaml(const CrclRobotConfig& robot, const std::string& indent) {
  std::string text = fmt::format(
      "{0}length_unit: {1}\n{0}angle_unit: {2}\n{0}validation: {3}\n{0}out_of_range: {4}\n", indent,
      robot.length_unit, robot.angle_unit, robot.strict ? "strict" : "lenient",
      robot.clamp_targets ? "clamp" : "refuse");
  if (robot.cartesian_min_m) {
    text +=
        fmt::format("{}cartesian_min_m: [{}]\n", indent, fmt::join(*robot.cartesian_min_m, ", "));
  }
  if (robot.cartesian_max_m) {
    text +=
        fmt::format("{}cartesian_max_m: [{}]\n", indent, fmt::join(*robot.cartesian_max_m, ", "));
  }
  return text;
}

}  // namespace

void read(const yaml::Node& node, CrclConfig& crcl) {
  if (!node) return;
  const auto map =
      node.map({"address", "ports", "max_connections", "length_unit", "angle_unit", "validation",
                "out_of_range", "cartesian_min_m", "cartesian_max_m", "robots"});
  crcl.address = map["address"].text_or(crcl.address);
  for (const auto& [robot, port] : map["ports"].entries()) {
    crcl.ports[robot] = static_cast<std::uint16_t>(port.integer_or(0, 0, kMaxPort));
  }
  crcl.max_connections =
      static_cast<std::uint32_t>(map["max_connections"].integer_or(crcl.max_connections, 1, 1024));
  read(map, crcl.all);
  for (const auto& [name, robot] : map["robots"].entries()) {
    CrclRobotConfig own = crcl.all;
    read(robot.map({"length_unit", "angle_unit", "validation", "out_of_range", "cartesian_min_m",
                    "cartesian_max_m"}),
         own);
    crcl.robots[name] = own;
  }
}

std::string to_yaml(const CrclConfig& crcl) {
  std::string text = fmt::format("crcl:\n  address: {}\n  ports:\n{}", scalar(crcl.address),
                                 ports_text(crcl.ports));
  text += fmt::format("  max_connections: {}\n", crcl.max_connections) + to_yaml(crcl.all, "  ");
  if (!crcl.robots.empty()) text += "  robots:\n";
  for (const auto& [name, robot] : crcl.robots) {
    text += fmt::format("    {}:\n", scalar(name)) + to_yaml(robot, "      ");
  }
  return text;
}

}  // namespace aprsim::server
