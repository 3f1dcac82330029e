#include "clients/ros2/cell/names.hpp"

#include <map>

namespace aprsim::ros2 {

std::string ros_token(std::string_view name) {
  std::string token;
  for (const char c : name) {
    const bool is_digit = c >= '0' && c <= '9';
    const bool is_letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    if (is_digit && token.empty()) token = "_";
    token += is_digit || is_letter ? c : '_';
  }
  return token;
}

std::vector<std::vector<std::string>> joint_names(const v1::CellDescription& cell) {
  std::map<std::string, int> uses;
  for (const auto& robot : cell.robots()) {
    for (const auto& joint : robot.joints()) ++uses[joint.name()];
  }
  std::vector<std::vector<std::string>> names;
  for (const auto& robot : cell.robots()) {
    auto& own = names.emplace_back();
    for (const auto& joint : robot.joints()) {
      own.push_back(uses[joint.name()] > 1 ? ros_token(robot.name()) + "_" + joint.name()
                                           : joint.name());
    }
  }
  return names;
}

}  // namespace aprsim::ros2
