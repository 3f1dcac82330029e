#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "world/api/description/cell_description.hpp"
#include "world/api/values/piece.hpp"
#include "world/api/values/pose.hpp"
#include "world/scene/model/outline.hpp"

/// Gears, trays, parts and fixtures: their shapes, and where a scene puts them. SI.
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

/// Recess in a tray's top face with an optional mouth chamfer: a frustum about z, or a prism along
/// z with the outline.
struct Pocket {
  double top_radius_m = 0, floor_radius_m = 0, depth_m = 0;
  double chamfer_m = 0;                           ///< depth of the mouth chamfer, 0 = none
  double chamfer_angle_rad = 0.7853981633974483;  ///< from the vertical
  /// Walls below the chamfer, in the slot's frame; none = round, else the radii are 0.
  std::optional<Outline> outline;
};

struct Slot {
  std::string name;
  std::string gear_type;                         ///< of the gear or part that it takes
  Eigen::Vector2d xy = Eigen::Vector2d::Zero();  ///< in the tray frame [m]
  Pocket pocket;
  double yaw_rad = 0;  ///< of the slot's frame in the tray frame
};

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
  std::map<std::string, std::string> gears;  ///< slot name -> body name of its gear or part
  std::vector<std::string> reachable_by;     ///< robots that reach every slot, tool down
};

struct GearInstance {
  std::string name;
  std::string type;
  Pose X_WP;
};

/// A rigid union of convex pieces.
struct PartType {
  std::string name;
  std::vector<api::Piece> pieces;
  double mass_kg = 0;
  Eigen::Vector3d com = Eigen::Vector3d::Zero();      ///< in the part's frame
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< about the com, axes of the part's frame
  std::string material;                               ///< see MaterialPair
};

struct PartInstance {
  std::string name;
  std::string type;
  Pose X_WP;
};

/// Something fixed that consists of convex pieces, such as a bin or a chute.
struct Fixture {
  std::string name;
  std::vector<api::Piece> pieces;
  Pose X_WP;
  std::string material;
};

/// Materials of what has none of its own. Parts are as gears and fixtures as fixed boxes, unless a
/// scene gives them a material.
inline constexpr const char *kGearMaterial = "gear", *kTrayMaterial = "tray",
                            *kFixedMaterial = "fixed", *kBeltMaterial = "belt",
                            *kRobotMaterial = "robot";

/// Contacts of parts and fixtures between two materials.
struct MaterialPair {
  std::string a, b;
  double friction = 0;     ///< Coulomb's coefficient
  double restitution = 0;  ///< share of the speed of approach that an impact gives back
  double rolling_m = 0, spinning_m = 0;  ///< torque across and about the normal, per normal force
};

}  // namespace aprsim::scene
