#include "world/scene/checks/type_checks.hpp"

#include <algorithm>
#include <cmath>

#include "world/scene/checks/millimetres.hpp"
#include "world/scene/checks/pocket_checks.hpp"

namespace aprsim::scene {

void check_gear_type(const yaml::Node& node, const GearType& type) {
  if (type.hub_bottom_radius_m > type.hub_top_radius_m) {
    node.error("a hub that widens downwards to " + mm(type.hub_bottom_radius_m),
               "hub.bottom_radius_m at most hub.top_radius_m, " + mm(type.hub_top_radius_m));
  }
  if (type.hub_top_radius_m >= type.disc_radius_m) {
    node.error("a hub radius of " + mm(type.hub_top_radius_m),
               "less than the disc's radius, " + mm(type.disc_radius_m));
  }
  if (type.hub_chamfer_m > std::min(type.hub_height_m, type.hub_bottom_radius_m)) {
    node.error("a hub chamfer of " + mm(type.hub_chamfer_m),
               "at most the hub's height and lower radius");
  }
  if (type.peg_radius_m >= type.disc_radius_m) {
    node.error("a peg radius of " + mm(type.peg_radius_m),
               "less than the disc's radius, " + mm(type.disc_radius_m));
  }
}

bool check_outline(const yaml::Node& node, const std::vector<Eigen::Vector2d>& corners) {
  constexpr double kShortest_m = 1e-4, kLeastTurn = 1e-3;  // sine of about 0.06 degrees
  const std::size_t n = corners.size();
  if (n < 3 || n > Outline::kMaxCorners) {
    node.error(std::to_string(n) + " corners",
               "3 to " + std::to_string(Outline::kMaxCorners) + " corners [x, y]");
    return false;
  }
  const auto side = [&](std::size_t i) -> Eigen::Vector2d {
    return corners[(i + 1) % n] - corners[i % n];
  };
  const auto cross = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a.x() * b.y() - a.y() * b.x();
  };
  double area = 0, turn = 0;
  for (std::size_t i = 0; i < n; ++i) area += cross(corners[i], corners[(i + 1) % n]) / 2;
  if (area < 0) {
    node.error("corners in clockwise order", "the corners counter-clockwise, seen from above");
    return false;
  }
  for (std::size_t i = 0; i < n; ++i) {
    const std::string corner = "corner " + std::to_string((i + 1) % n);
    const Eigen::Vector2d a = side(i), b = side(i + 1);
    if (a.norm() < kShortest_m) {
      node.error(corner + " " + mm(a.norm()) + " from the one before", "at least 0.1 mm between");
      return false;
    }
    if (cross(a, b) < kLeastTurn * a.norm() * b.norm()) {
      node.error(corner + " that does not turn left", "a convex outline without straight corners");
      return false;
    }
    turn += std::atan2(cross(a, b), a.dot(b));
  }
  constexpr double kOnce = 7;  // [rad], between one turn and two
  if (turn < kOnce) return true;
  node.error("an outline that winds around more than once", "each corner once");
  return false;
}

void check_label(const yaml::Node& node, const TrayType& type) {
  const double half = type.label->size_m / 2;
  for (const double x : {-half, half}) {
    for (const double y : {-half, half}) {
      if (to_edge(type, {x, y}) > 0) continue;
      node.error("a label of " + mm(type.label->size_m), "one within the tray's top face");
      return;
    }
  }
}

void check_tray_type(const std::vector<yaml::Node>& slot_nodes, const TrayType& type,
                     const std::map<std::string, GearType>& gears) {
  for (std::size_t i = 0; i < type.slots.size(); ++i) {
    const Slot& slot = type.slots[i];
    const yaml::Node& node = slot_nodes[i];
    check_pocket_in_slab(node, type, slot);
    const auto gear = gears.find(slot.gear_type);
    if (gear != gears.end()) check_gear_in_pocket(node, slot, gear->second);
    for (std::size_t j = 0; j < i; ++j) {
      check_pockets_apart(node, type.slots[j], slot);
    }
  }
}

}  // namespace aprsim::scene
