#pragma once

#include <algorithm>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "world/api/description/cell_description.hpp"
#include "world/api/values/pose.hpp"

/// Gears and trays: their shapes, and where a scene puts them. SI.
namespace aprsim::scene {

/// Surface of revolution about z, all z relative to the gear frame (origin: disc underside).
struct GearType {
  std::string name;
  double disc_radius_m = 0, disc_height_m = 0;                             ///< z 0 .. disc_height
  double hub_top_radius_m = 0, hub_bottom_radius_m = 0, hub_height_m = 0;  ///< z -hub_height .. 0
  double hub_chamfer_m = 0;                ///< 45 deg at the hub's lower rim
  double peg_radius_m = 0, peg_top_m = 0;  ///< z disc_height .. peg_top
  double teeth_outer_radius_m = 0;         ///< looks only
  double mass_kg = 0;
};

/// Recess of revolution in a tray's top face, axis z: a frustum with an optional mouth chamfer.
struct Pocket {
  double top_radius_m = 0, floor_radius_m = 0, depth_m = 0;
  double chamfer_m = 0;                           ///< depth of the mouth chamfer, 0 = none
  double chamfer_angle_rad = 0.7853981633974483;  ///< from the vertical
};

struct Slot {
  std::string name;
  std::string gear_type;
  Eigen::Vector2d xy = Eigen::Vector2d::Zero();  ///< in the tray frame [m]
  Pocket pocket;
};

/// A convex polygon in the plane z = 0 of a tray, counter-clockwise seen from above [m].
struct Outline {
  static constexpr std::size_t kMaxCorners = 24;
  std::vector<Eigen::Vector2d> corners;
  std::vector<Eigen::Vector2d> normals;  ///< outward, of the side from corner i to corner i + 1

  /// Distance of a point from the nearest side's line, positive inside.
  [[nodiscard]] double depth_of(const Eigen::Vector2d& p) const {
    double depth = 1e30;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      depth = std::min(depth, normals[i].dot(corners[i] - p));
    }
    return depth;
  }
};

/// The outline with these corners, which must be convex and counter-clockwise.
[[nodiscard]] inline Outline outline_of(std::vector<Eigen::Vector2d> corners) {
  Outline outline;
  outline.corners = std::move(corners);
  for (std::size_t i = 0; i < outline.corners.size(); ++i) {
    const Eigen::Vector2d side =
        outline.corners[(i + 1) % outline.corners.size()] - outline.corners[i];
    outline.normals.push_back(Eigen::Vector2d(side.y(), -side.x()).normalized());
  }
  return outline;
}

/// A square recess for a label in the tray's top face, centred on its frame. Nothing collides with
/// it.
struct LabelRecess {
  double size_m = 0, depth_m = 0;
};

struct TrayType {
  std::string name;
  api::BodyKind kind = api::BodyKind::kPartTray;
  /// The slab's rectangle, or the one around its outline.
  Eigen::Vector2d min_xy = Eigen::Vector2d::Zero(), max_xy = Eigen::Vector2d::Zero();
  std::optional<Outline> outline;  ///< of the slab, where it is no rectangle along x and y
  double thickness_m = 0;          ///< z -thickness .. 0
  double mass_kg = 0;
  std::optional<LabelRecess> label;
  std::vector<Slot> slots;
};

struct TrayInstance {
  std::string name;
  std::string type;
  Pose X_WP;                                 ///< tray frame (top face) in world
  std::map<std::string, std::string> gears;  ///< slot name -> gear body name
  std::vector<std::string> reachable_by;     ///< robots that reach every slot, tool down
};

struct GearInstance {
  std::string name;
  std::string type;
  Pose X_WP;
};

}  // namespace aprsim::scene
