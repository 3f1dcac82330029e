#include "world/scene/readers/pocket_reader.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "world/scene/checks/type_checks.hpp"
#include "world/scene/readers/reading.hpp"

namespace aprsim::scene {
namespace {

constexpr yaml::Range kChamferAngle{.min = 0, .max = 90, .open_min = true, .open_max = true};

Outline read_rectangle(const yaml::Node& node) {
  const yaml::Map keys = node.map({"size_m", "corner_radius_m"});
  const std::array<double, 2> sides = keys["size_m"].numbers<2>(kLength);
  const Eigen::Vector2d size(sides[0], sides[1]);
  const double most = 0.5 * size.minCoeff();
  return rectangle_outline(size, keys["corner_radius_m"].number_or(0, yaml::between(0, most)));
}

Outline read_polygon(const yaml::Node& node) {
  const yaml::Node list = node.map({"corners_m"})["corners_m"];
  std::vector<Eigen::Vector2d> corners;
  for (const yaml::Node& item : list.items()) corners.push_back(read_xy(item));
  if (!check_outline(list, corners)) corners = {{0, 0}, {1, 0}, {0, 1}};
  return outline_of(std::move(corners));
}

void read_radii(const yaml::Map& keys, Pocket& pocket) {
  pocket.top_radius_m = keys["top_radius_m"].number(kLength);
  pocket.floor_radius_m =
      keys["floor_radius_m"].number({.min = 0, .max = pocket.top_radius_m, .open_min = true});
}

void read_walls(const yaml::Node& node, const yaml::Map& keys, Pocket& pocket) {
  const bool rectangle = static_cast<bool>(keys["rectangle"]);
  const bool polygon = static_cast<bool>(keys["polygon"]);
  if (rectangle && polygon) {
    node.error("rectangle beside polygon", "one of the two, or the two radii of a round pocket");
  }
  if (!rectangle && !polygon) return read_radii(keys, pocket);
  for (const char* key : {"top_radius_m", "floor_radius_m"}) {
    if (const yaml::Node radius = keys[key]) {
      radius.error(std::string(key) + " of a pocket that is not round",
                   rectangle ? "rectangle alone" : "polygon alone");
    }
  }
  pocket.outline = rectangle ? read_rectangle(keys["rectangle"]) : read_polygon(keys["polygon"]);
}

}  // namespace

Outline rectangle_outline(const Eigen::Vector2d& size_m, double corner_radius_m) {
  constexpr int kChords = static_cast<int>(Outline::kMaxCorners) / 4;  // of each corner
  constexpr double kQuarter = std::numbers::pi / 2, kStep = kQuarter / kChords;
  constexpr std::array<std::pair<double, double>, 4> kSigns{{{1, 1}, {-1, 1}, {-1, -1}, {1, -1}}};
  std::vector<Eigen::Vector2d> corners;
  for (std::size_t i = 0; i < kSigns.size(); ++i) {
    const Eigen::Vector2d sign(kSigns[i].first, kSigns[i].second);
    if (corner_radius_m == 0) {
      corners.emplace_back(0.5 * sign.cwiseProduct(size_m));
      continue;
    }
    // The arc's tangents in kChords + 1 directions meet at these corners.
    const Eigen::Vector2d centre =
        sign.cwiseProduct(0.5 * size_m - Eigen::Vector2d::Constant(corner_radius_m));
    const double reach = corner_radius_m / std::cos(0.5 * kStep);
    for (int k = 0; k < kChords; ++k) {
      const double angle = kQuarter * static_cast<double>(i) + kStep * (k + 0.5);
      corners.push_back(centre + reach * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    }
  }
  return outline_of(std::move(corners));
}

Pocket read_pocket(const yaml::Node& node) {
  const yaml::Map keys = node.map({"top_radius_m", "floor_radius_m", "rectangle", "polygon",
                                   "depth_m", "chamfer_m", "chamfer_angle_deg"});
  Pocket pocket;
  read_walls(node, keys, pocket);
  pocket.depth_m = keys["depth_m"].number(kLength);
  pocket.chamfer_m = keys["chamfer_m"].number_or(0, yaml::between(0, pocket.depth_m));
  pocket.chamfer_angle_rad = radians(keys["chamfer_angle_deg"].number_or(45, kChamferAngle));
  return pocket;
}

}  // namespace aprsim::scene
