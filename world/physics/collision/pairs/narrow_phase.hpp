#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "world/physics/collision/shapes/contact.hpp"
#include "world/physics/collision/shapes/gear_shape.hpp"
#include "world/physics/collision/shapes/prism.hpp"
#include "world/scene/model/scene.hpp"

/// Contacts between the cell's shapes, from exact geometry; no ODE. Each function appends the
/// contacts of one pair, reduced to what supports the body, in a fixed order; a contact is made
/// only when depth > 0. The normal points from the second object (b) into the first (a). No call
/// allocates once `out` has its capacity.
namespace aprsim::physics {

/// Gear (frame origin at the disc's underside, z along the peg) on or in a tray: disc shoulder on
/// the top face (4 points on the true radius), hub in the pockets (wall, floor, chamfer: at most 4
/// wall and 4 flat), mouth edges on the hub, gear outside any pocket on the slab's faces and edges.
void gear_tray(const detail::GearShape& gear, const Eigen::Isometry3d& X_WG,
               const scene::TrayType& tray, const Eigen::Isometry3d& X_WP, BodyIndex a, BodyIndex b,
               std::vector<Contact>& out);

void gear_gear(const detail::GearShape& gear_a, const Eigen::Isometry3d& X_WA,
               const detail::GearShape& gear_b, const Eigen::Isometry3d& X_WB, BodyIndex a,
               BodyIndex b, std::vector<Contact>& out);

/// A fixed horizontal-or-not box (table, belt, conveyor frame); the gear may stand, lie or lean.
void gear_box(const detail::GearShape& gear, const Eigen::Isometry3d& X_WG,
              const Eigen::Vector3d& size, const Eigen::Isometry3d& X_WS, BodyIndex a, BodyIndex b,
              SurfacePair pair, std::vector<Contact>& out);

/// Box against box (tray slab on table, belt or another tray; finger and palm boxes on anything
/// box-like), at most 4 well-chosen points.
void box_box(const Eigen::Vector3d& size_a, const Eigen::Isometry3d& X_WA,
             const Eigen::Vector3d& size_b, const Eigen::Isometry3d& X_WB, BodyIndex a, BodyIndex b,
             SurfacePair pair, std::vector<Contact>& out);

/// A box about its frame's origin, or a convex prism in that box, as high as it is.
struct SlabShape {
  Eigen::Vector3d size = Eigen::Vector3d::Zero();    ///< of the box
  const scene::Outline* outline = nullptr;           ///< of the prism; none = the box itself
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();  ///< of the box, in the outline's frame
};

/// The same as box_box() between two boxes; else at most eight points of one face.
void slab_slab(const SlabShape& slab_a, const Eigen::Isometry3d& X_WA, const SlabShape& slab_b,
               const Eigen::Isometry3d& X_WB, BodyIndex a, BodyIndex b, SurfacePair pair,
               std::vector<Contact>& out);

/// A cylinder (b) about the z axis of its frame, centred on it, against a slab (a).
void slab_cylinder(const SlabShape& slab, const Eigen::Isometry3d& X_WS, double radius_m,
                   double length_m, const Eigen::Isometry3d& X_WC, BodyIndex a, BodyIndex b,
                   SurfacePair pair, std::vector<Contact>& out);

/// The same for a capsule, whose cylindrical part is `length_m` long (0 = a sphere): at most three
/// points, of its ends and where it is deepest.
void slab_capsule(const SlabShape& slab, const Eigen::Isometry3d& X_WS, double radius_m,
                  double length_m, const Eigen::Isometry3d& X_WC, BodyIndex a, BodyIndex b,
                  SurfacePair pair, std::vector<Contact>& out);

/// A finger's pad. Finger frame: origin at the finger tip's centre in the tool's xz plane on the
/// pad's face line, z towards the palm (against the approach), y pointing out of the pad face (the
/// closing direction), x across. A V pad's groove is cut into that face, symmetric about x = 0.
struct Pad {
  scene::PadShape shape = scene::PadShape::kV;
  double height_m = 0;  ///< z 0 .. height
  double width_m = 0;   ///< x -width/2 .. width/2
  double depth_m = 0;   ///< y -depth .. 0
  double v_half_angle_rad = 0;
  double v_depth_m = 0;  ///< of the groove; 0 = just deep enough for the peg: see v_groove_depth
};

/// Depth of the groove [m]: v_depth_m, or when that is 0 such that both faces hold a peg of this
/// radius 5 % inside the groove's rims; never more than what width and depth allow.
[[nodiscard]] double v_groove_depth(const Pad& pad, double peg_radius_m);

/// Half of a V pad, in its frame: convex, joined to the other half at x = 0 by an internal side.
/// `side`: 1 for x > 0, -1 for x < 0.
[[nodiscard]] detail::Prism half_v_pad(const Pad& pad, double groove_depth, double side);

/// Pad on a gear's peg (flat: 2 points; V: up to 4), the pad's lower edge and corners on the disc,
/// the pad's underside on the top of the peg. Never tunnels: a finger that comes down on the peg is
/// stopped by its underside.
void pad_gear(const Pad& pad, const Eigen::Isometry3d& X_WD, const detail::GearShape& gear,
              const Eigen::Isometry3d& X_WG, BodyIndex a, BodyIndex b, std::vector<Contact>& out);

}  // namespace aprsim::physics
