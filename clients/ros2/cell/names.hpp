#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "aprsim/v1/cell.pb.h"

namespace aprsim::ros2 {

/// A name of the scene as a token of a ROS name: characters beyond [A-Za-z0-9_] become '_', and a
/// digit at the start gets one before it.
[[nodiscard]] std::string ros_token(std::string_view name);

/// Names of all joints in the order of the robots and their joints: those of the robots'
/// descriptions, with "ROBOT_" before a name that two robots have.
[[nodiscard]] std::vector<std::vector<std::string>> joint_names(const v1::CellDescription& cell);

}  // namespace aprsim::ros2
