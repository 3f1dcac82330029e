#include "clients/ros2/trays/tray_area.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>

#include "clients/ros2/cell/names.hpp"

namespace aprsim::ros2 {
namespace {

constexpr int kLabels = 50;  // markers of the dictionary DICT_5X5_50

constexpr std::array<std::pair<std::string_view, std::string_view>, 3> kSurfaces{
    {{"_table", "table"}, {"_conveyor", "conveyor"}, {"_belt", "conveyor"}}};

}  // namespace

std::optional<TrayArea> tray_area_of(const v1::CameraDescription& camera,
                                     const v1::CellDescription& cell) {
  if (!camera.has_camera_in_world()) return std::nullopt;
  for (const auto& [ending, surface] : kSurfaces) {
    std::string area = camera.name();
    if (area.size() <= ending.size() || !area.ends_with(ending)) continue;
    area.resize(area.size() - ending.size());
    const bool has_frames =
        std::ranges::any_of(cell.robots(), [&](const auto& robot) { return robot.name() == area; });
    return TrayArea{"/" + ros_token(area) + "/" + std::string(surface) + "_trays_info", has_frames};
  }
  return std::nullopt;
}

int label_of(std::string_view tray) {
  int number = 0, scale = 1;
  for (auto c = tray.rbegin(); c != tray.rend() && std::isdigit(static_cast<unsigned char>(*c));
       ++c) {
    number = (number + scale * (*c - '0')) % kLabels;
    scale = scale * 10 % kLabels;
  }
  return number;
}

}  // namespace aprsim::ros2
