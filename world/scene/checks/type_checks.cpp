#include "world/scene/checks/type_checks.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace aprsim::scene {
namespace {

std::string mm(double metres) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g mm", metres * 1e3);
  return text;
}

/// Radius of the pocket's opening in the top face.
double mouth_radius(const Pocket& pocket) {
  return pocket.top_radius_m + pocket.chamfer_m * std::tan(pocket.chamfer_angle_rad);
}

/// Radius of the pocket's wall at a depth below the top face, the chamfer left out.
double wall_radius(const Pocket& pocket, double depth) {
  return pocket.top_radius_m +
         (pocket.floor_radius_m - pocket.top_radius_m) * std::min(depth / pocket.depth_m, 1.0);
}

/// Distance of a point from the nearest edge of the slab.
double to_edge(const TrayType& type, const Eigen::Vector2d& p) {
  if (type.outline) return type.outline->depth_of(p);
  return std::min((p - type.min_xy).minCoeff(), (type.max_xy - p).minCoeff());
}

void check_pocket_in_slab(const yaml::Node& node, const TrayType& type, const Slot& slot) {
  if (slot.pocket.depth_m >= type.thickness_m) {
    node.error("slot " + slot.name + " with a pocket " + mm(slot.pocket.depth_m) + " deep",
               "less than the tray's thickness of " + mm(type.thickness_m));
  }
  const double edge = to_edge(type, slot.xy);
  const double mouth = mouth_radius(slot.pocket);
  if (mouth >= edge) {
    node.error("slot " + slot.name + " with a mouth radius of " + mm(mouth),
               "less than the " + mm(edge) + " from its centre to the tray's edge");
  }
}

void check_gear_in_pocket(const yaml::Node& node, const Slot& slot, const GearType& gear) {
  const std::string what = "slot " + slot.name + " of gear type " + gear.name + " with a ";
  if (gear.hub_height_m > slot.pocket.depth_m) {
    node.error(what + "hub " + mm(gear.hub_height_m) + " high",
               "at most the pocket's depth of " + mm(slot.pocket.depth_m));
  }
  const double low = wall_radius(slot.pocket, gear.hub_height_m);
  if (gear.hub_top_radius_m > slot.pocket.top_radius_m) {
    node.error(what + "hub radius of " + mm(gear.hub_top_radius_m) + " at the disc",
               "at most the pocket's " + mm(slot.pocket.top_radius_m));
  }
  if (gear.hub_bottom_radius_m > low) {
    node.error(what + "hub radius of " + mm(gear.hub_bottom_radius_m) + " at its lower end",
               "at most the pocket's " + mm(low) + " there");
  }
  if (gear.disc_radius_m <= mouth_radius(slot.pocket)) {
    node.error(what + "disc radius of " + mm(gear.disc_radius_m),
               "more than the mouth radius of " + mm(mouth_radius(slot.pocket)) +
                   ", so that the disc rests on the tray");
  }
}

}  // namespace

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
      const Slot& other = type.slots[j];
      const double apart = (slot.xy - other.xy).norm();
      const double needed = mouth_radius(slot.pocket) + mouth_radius(other.pocket);
      if (apart <= needed) {
        node.error("slots " + other.name + " and " + slot.name + " " + mm(apart) + " apart",
                   "more than the sum of their mouth radii, " + mm(needed));
      }
    }
  }
}

}  // namespace aprsim::scene
