#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string_view>

#include "world/api/description/cell_description.hpp"

/// Robots of different descriptions of a cell, as resets to other scenes have them.
namespace aprsim::api {

/// Index of the robot with this name; absent = the cell has none.
[[nodiscard]] inline std::optional<std::size_t> robot_named(const CellDescription& cell,
                                                            std::string_view name) {
  const auto found = std::ranges::find(cell.robots, name, &RobotDescription::name);
  if (found == cell.robots.end()) return std::nullopt;
  return static_cast<std::size_t>(found - cell.robots.begin());
}

/// Whether clients of one robot can go on with the other: name, model and number of joints agree.
[[nodiscard]] inline bool same_robot(const RobotDescription& a, const RobotDescription& b) {
  return a.name == b.name && a.model == b.model && a.joints.size() == b.joints.size();
}

}  // namespace aprsim::api
