#include "world/scene/checks/pocket_checks.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "world/scene/checks/millimetres.hpp"

namespace aprsim::scene {
namespace {

/// Horizontal reach of the chamfer beyond the wall.
double chamfer_width(const Pocket& pocket) {
  return pocket.chamfer_m * std::tan(pocket.chamfer_angle_rad);
}

/// Radius of the pocket's opening in the top face.
double mouth_radius(const Pocket& pocket) { return pocket.top_radius_m + chamfer_width(pocket); }

/// Radius of the pocket's wall at a depth below the top face, the chamfer left out.
double wall_radius(const Pocket& pocket, double depth) {
  return pocket.top_radius_m +
         (pocket.floor_radius_m - pocket.top_radius_m) * std::min(depth / pocket.depth_m, 1.0);
}

/// The pocket's opening in the top face, in the tray frame: all within a radius of a convex
/// polygon, which is a point if the pocket is round.
struct Mouth {
  std::vector<Eigen::Vector2d> corners, normals;
  double radius_m = 0;

  explicit Mouth(const Slot& slot) {
    const Pocket& pocket = slot.pocket;
    if (!pocket.outline) {
      corners = {slot.xy};
      radius_m = mouth_radius(pocket);
      return;
    }
    Outline outline =
        placed(widened(*pocket.outline, chamfer_width(pocket)), slot.xy, slot.yaw_rad);
    corners = std::move(outline.corners);
    normals = std::move(outline.normals);
  }
  /// Least and most n . p.
  [[nodiscard]] std::pair<double, double> reach(const Eigen::Vector2d& n) const {
    double least = n.dot(corners[0]), most = least;
    for (const Eigen::Vector2d& corner : corners) {
      least = std::min(least, n.dot(corner));
      most = std::max(most, n.dot(corner));
    }
    return {least - radius_m, most + radius_m};
  }
};

/// Distance of two mouths, negative where they overlap: the largest over the normals of both, and
/// over the directions between their corners (separating axes: Ericson 2005, ch. 5.2.1).
double gap_between(const Mouth& a, const Mouth& b) {
  double gap = -1e30;
  const auto test = [&](const Eigen::Vector2d& n) {
    const auto [a_least, a_most] = a.reach(n);
    const auto [b_least, b_most] = b.reach(n);
    gap = std::max({gap, b_least - a_most, a_least - b_most});
  };
  for (const Eigen::Vector2d& n : a.normals) test(n);
  for (const Eigen::Vector2d& n : b.normals) test(n);
  for (const Eigen::Vector2d& p : a.corners) {
    for (const Eigen::Vector2d& q : b.corners) {
      if (p != q) test((q - p).normalized());
    }
  }
  return gap;
}

void check_gear_in_outline(const yaml::Node& node, const Slot& slot, const GearType& gear) {
  const std::string what = "slot " + slot.name + " of gear type " + gear.name + " with a ";
  const Outline& wall = *slot.pocket.outline;
  const double to_wall = wall.depth_of(Eigen::Vector2d::Zero());
  if (gear.hub_top_radius_m > to_wall) {
    node.error(what + "hub radius of " + mm(gear.hub_top_radius_m) + " at the disc",
               "at most the " + mm(to_wall) + " from the slot's centre to the pocket's wall");
  }
  const double to_mouth = to_wall + chamfer_width(slot.pocket);
  if (gear.disc_radius_m <= to_mouth) {
    node.error(what + "disc radius of " + mm(gear.disc_radius_m),
               "more than the " + mm(to_mouth) +
                   " from the slot's centre to the mouth, so that the disc rests on the tray");
  }
}

void check_gear_in_round(const yaml::Node& node, const Slot& slot, const GearType& gear) {
  const std::string what = "slot " + slot.name + " of gear type " + gear.name + " with a ";
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

double to_edge(const TrayType& type, const Eigen::Vector2d& p) {
  if (type.outline) return type.outline->depth_of(p);
  return std::min((p - type.min_xy).minCoeff(), (type.max_xy - p).minCoeff());
}

void check_pocket_in_slab(const yaml::Node& node, const TrayType& type, const Slot& slot) {
  if (slot.pocket.depth_m >= type.thickness_m) {
    node.error("slot " + slot.name + " with a pocket " + mm(slot.pocket.depth_m) + " deep",
               "less than the tray's thickness of " + mm(type.thickness_m));
  }
  if (!slot.pocket.outline) {
    const double edge = to_edge(type, slot.xy);
    const double mouth = mouth_radius(slot.pocket);
    if (mouth >= edge) {
      node.error("slot " + slot.name + " with a mouth radius of " + mm(mouth),
                 "less than the " + mm(edge) + " from its centre to the tray's edge");
    }
    return;
  }
  double inside = 1e30;
  for (const Eigen::Vector2d& corner : Mouth(slot).corners) {
    inside = std::min(inside, to_edge(type, corner));
  }
  if (inside > 0) return;
  node.error("slot " + slot.name + " with a pocket that reaches " + mm(-inside) +
                 " beyond the tray's edge",
             "one within the tray's top face");
}

void check_pockets_apart(const yaml::Node& node, const Slot& other, const Slot& slot) {
  if (!slot.pocket.outline && !other.pocket.outline) {
    const double apart = (slot.xy - other.xy).norm();
    const double needed = mouth_radius(slot.pocket) + mouth_radius(other.pocket);
    if (apart > needed) return;
    node.error("slots " + other.name + " and " + slot.name + " " + mm(apart) + " apart",
               "more than the sum of their mouth radii, " + mm(needed));
    return;
  }
  const double gap = gap_between(Mouth(other), Mouth(slot));
  if (gap > 0) return;
  node.error(
      "slots " + other.name + " and " + slot.name + " with pockets that overlap by " + mm(-gap),
      "pockets apart from each other");
}

void check_gear_in_pocket(const yaml::Node& node, const Slot& slot, const GearType& gear) {
  if (gear.hub_height_m > slot.pocket.depth_m) {
    node.error("slot " + slot.name + " of gear type " + gear.name + " with a hub " +
                   mm(gear.hub_height_m) + " high",
               "at most the pocket's depth of " + mm(slot.pocket.depth_m));
  }
  if (slot.pocket.outline) return check_gear_in_outline(node, slot, gear);
  check_gear_in_round(node, slot, gear);
}

}  // namespace aprsim::scene
