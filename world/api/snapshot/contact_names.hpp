#pragma once

#include <algorithm>
#include <cstddef>
#include <string>

#include "world/api/snapshot/snapshot.hpp"

/// Names of the sides of a contact. They are unique within a category only: a tray, a robot
/// and something fixed may share one.
namespace aprsim::api {

/// Name of a robot's part as ContactSide counts them: "palm", "finger_1", "finger_2" or its link's
/// name; empty when the part is not known.
[[nodiscard]] inline std::string part_name(const RobotDescription& robot, int part) {
  if (part < 0) return "";
  if (part == 0) return "palm";
  if (part < ContactSide::kFirstLink) return "finger_" + std::to_string(part);
  const auto link = static_cast<std::size_t>(part - ContactSide::kFirstLink);
  return link < robot.links.size() ? robot.links[link] : "";
}

/// The thing's name; where things of other categories have it too, with the category before it:
/// "tray post", "gear post", "part post", "robot post", "tool post", "fixed post".
[[nodiscard]] inline std::string contact_name(const CellDescription& cell,
                                              const ContactSide& side) {
  using Kind = ContactSide::Kind;
  const auto index = static_cast<std::size_t>(side.index);
  const BodyKind body = side.kind == Kind::kBody ? cell.bodies[index].kind : BodyKind::kGear;
  const std::string& name = side.kind == Kind::kBody    ? cell.bodies[index].name
                            : side.kind == Kind::kRobot ? cell.robots[index].name
                            : side.kind == Kind::kTool  ? cell.tools[index].name
                                                        : cell.fixed[index];
  const auto named = [&name](const auto& thing) { return thing.name == name; };
  const bool is_body = std::any_of(cell.bodies.begin(), cell.bodies.end(), named);
  const bool is_robot = std::any_of(cell.robots.begin(), cell.robots.end(), named);
  const bool is_tool = std::any_of(cell.tools.begin(), cell.tools.end(), named);
  const bool is_fixed = std::find(cell.fixed.begin(), cell.fixed.end(), name) != cell.fixed.end();
  if (int{is_body} + int{is_robot} + int{is_tool} + int{is_fixed} < 2) return name;
  const char* category = side.kind == Kind::kBody    ? (body == BodyKind::kGear   ? "gear "
                                                        : body == BodyKind::kPart ? "part "
                                                                                  : "tray ")
                         : side.kind == Kind::kRobot ? "robot "
                         : side.kind == Kind::kTool  ? "tool "
                                                     : "fixed ";
  return category + name;
}

}  // namespace aprsim::api
