#include <algorithm>
#include <array>
#include <cmath>

#include "world/physics/collision/pairs/circle_edge_vs_gear.hpp"
#include "world/physics/collision/pairs/gear_vs_prism.hpp"
#include "world/physics/collision/pairs/narrow_phase.hpp"
#include "world/physics/collision/pairs/outline_contacts.hpp"
#include "world/physics/collision/shapes/length.hpp"

// A gear against each thing made of prisms: a box, a tray's slab with pockets, a finger's pad. Each
// takes the pair into the frame of the prism, collects candidates, and keeps what supports the
// gear.
namespace aprsim::physics {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// Pockets that one gear can reach at once.
constexpr int kMaxNearPockets = 8;

struct NearPockets {
  std::array<detail::PocketProfile, kMaxNearPockets> items;
  std::size_t count = 0;
};

/// The round pockets whose mouth the gear's bounding sphere overlaps, in the tray's order.
void find_near_pockets(const detail::GearShape& gear, const Isometry3d& X_PG,
                       const scene::TrayType& tray, NearPockets& near) {
  const Vector3d centre = X_PG * gear.middle();
  const double radius = length(gear.r_max, 0.5 * (gear.z_high - gear.z_low));
  // The order of the tray is the order of the contacts, and so part of the reproducible result.
  for (const scene::Slot& slot : tray.slots) {
    if (slot.pocket.outline) continue;
    const scene::Pocket& p = slot.pocket;
    // Bound of the mouth without a tangent: chamfers are at most as wide as 6 times their depth.
    const double reach = radius + p.top_radius_m + 6 * p.chamfer_m;
    if ((slot.xy - centre.head<2>()).squaredNorm() > reach * reach) continue;
    if (near.count < kMaxNearPockets) near.items[near.count++] = detail::PocketProfile(slot);
  }
}

/// The circular edges of the pocket's mouth on the gear.
void mouth_on_gear(const detail::GearShape& gear, const Isometry3d& X_PG,
                   const detail::PocketProfile& pocket, detail::Candidates& out) {
  detail::Circle circle;
  circle.axis = X_PG.linear().row(2).transpose();
  const auto touch = [&](double r, double z) {
    circle.r = r;
    circle.c = X_PG.linear().transpose() * (Vector3d(pocket.x, pocket.y, z) - X_PG.translation());
    detail::circle_on_gear(gear, X_PG, circle, out);
  };
  // Two circular edges per pocket: the mouth and, below a chamfer, the edge between chamfer and
  // wall.
  touch(pocket.r_mouth, 0);
  if (pocket.chamfered()) touch(pocket.r_edge, pocket.z_edge);
}

/// The gear on a tray where pockets with outlines are near.
void gear_on_outlines(const detail::GearShape& gear, const Isometry3d& X_PG,
                      const detail::TrayMaterial& material, detail::Candidates& out) {
  detail::Candidates on_slab;
  if (!detail::gear_on_prism(gear, X_PG, material.slab, material.round, on_slab)) return;
  material.outlines.keep_on_slab(on_slab, out);
  for (const detail::PocketProfile& pocket : material.round) {
    mouth_on_gear(gear, X_PG, pocket, out);
  }
  for (const detail::PocketOutline& pocket : material.outlines) {
    detail::gear_in_outline(gear, X_PG, pocket, material, out);
  }
}

}  // namespace

detail::Prism half_v_pad(const Pad& pad, double groove_depth, double side) {
  const double half = 0.5 * pad.width_m, back = -pad.depth_m;
  const double mouth = groove_depth * std::tan(pad.v_half_angle_rad);
  const double c = std::cos(pad.v_half_angle_rad), s = std::sin(pad.v_half_angle_rad);
  // Counter-clockwise from the rear; the halves mirror each other.
  // Convex decomposition: the notch is concave. The internal side has no exit, so that no contact
  // pushes a peg from one half into the other.
  detail::Prism prism;
  const Vector2d rear(0, back), corner(side * half, back), front(side * half, 0),
      rim(side * mouth, 0), apex(0, -groove_depth);
  const Vector2d to_rear(0, -1), outside(side, 0), face(0, 1), groove(-side * c, s),
      joint(-side, 0);
  using Sides = std::array<Vector2d, 5>;
  if (side > 0) {
    prism.set_sides(Sides{rear, corner, front, rim, apex},
                    Sides{to_rear, outside, face, groove, joint});
    prism.internal[4] = true;
  } else {
    prism.set_sides(Sides{rear, apex, rim, front, corner},
                    Sides{joint, groove, face, outside, to_rear});
    prism.internal[0] = true;
  }
  prism.z0 = 0;
  prism.z1 = pad.height_m;
  const Vector2d middle = 0.2 * (rear + corner + front + rim + apex);
  prism.middle << middle, 0.5 * pad.height_m;
  return prism;
}

void gear_box(const detail::GearShape& gear, const Isometry3d& X_WG, const Vector3d& size,
              const Isometry3d& X_WS, BodyIndex a, BodyIndex b, SurfacePair pair,
              std::vector<Contact>& out) {
  const Isometry3d X_SG = X_WS.inverse(Eigen::Isometry) * X_WG;
  detail::Candidates points;
  const detail::Prism box = detail::box_prism(-0.5 * size, 0.5 * size);
  // Gear and box are convex: their contact is the gear's rims on the box's faces and the box's
  // edges on the gear.
  if (!detail::gear_on_prism(gear, X_SG, box, {}, points)) return;
  detail::emit_reduced_by_axis(points, X_SG.linear().col(2), {X_WS, a, b, pair, out});
}

void gear_tray(const detail::GearShape& gear, const Isometry3d& X_WG, const scene::TrayType& tray,
               const Isometry3d& X_WP, BodyIndex a, BodyIndex b, std::vector<Contact>& out) {
  const Isometry3d X_PG = X_WP.inverse(Eigen::Isometry) * X_WG;
  const detail::Prism slab = detail::slab_prism(tray);
  NearPockets near;
  find_near_pockets(gear, X_PG, tray, near);
  const std::span<const detail::PocketProfile> pockets(near.items.data(), near.count);
  const Vector3d centre = X_PG * gear.middle();
  const double radius = length(gear.r_max, 0.5 * (gear.z_high - gear.z_low));
  const detail::NearbyOutlines outlines(tray, centre.head<2>(), radius);
  detail::Candidates points;
  if (!outlines.empty()) {
    gear_on_outlines(gear, X_PG, {slab, pockets, outlines}, points);
    return detail::emit_reduced_by_direction(points, {X_WP, a, b, SurfacePair::kGearTray, out});
  }
  if (!detail::gear_on_prism(gear, X_PG, slab, pockets, points)) return;
  for (const detail::PocketProfile& pocket : pockets) mouth_on_gear(gear, X_PG, pocket, points);
  detail::emit_reduced_by_axis(points, X_PG.linear().col(2),
                               {X_WP, a, b, SurfacePair::kGearTray, out});
}

/// Both faces touch a peg of radius r at r cos(half angle) from the middle.
double v_groove_depth(const Pad& pad, double peg_radius_m) {
  constexpr double kInside = 1.05, kOfHalfWidth = 0.98, kOfDepth = 0.8;
  // A peg of radius r touches both faces of a V with half angle a at a distance r cos(a) from the
  // middle plane, r cos(a) / tan(a) above the apex.
  const double tangent = std::tan(pad.v_half_angle_rad);
  const double wanted = pad.v_depth_m > 0
                            ? pad.v_depth_m
                            : kInside * peg_radius_m * std::cos(pad.v_half_angle_rad) / tangent;
  return std::min({wanted, kOfHalfWidth * 0.5 * pad.width_m / tangent, kOfDepth * pad.depth_m});
}

void pad_gear(const Pad& pad, const Isometry3d& X_WD, const detail::GearShape& gear,
              const Isometry3d& X_WG, BodyIndex a, BodyIndex b, std::vector<Contact>& out) {
  const Isometry3d X_DG = X_WD.inverse(Eigen::Isometry) * X_WG;
  detail::Candidates points;
  if (pad.shape == scene::PadShape::kFlat) {
    const double half = 0.5 * pad.width_m;
    detail::gear_on_prism(gear, X_DG,
                          detail::box_prism({-half, -pad.depth_m, 0}, {half, 0, pad.height_m}), {},
                          points);
  } else {
    // The pad with its groove is not convex: two halves.
    const double groove = v_groove_depth(pad, gear.r_peg);
    detail::gear_on_prism(gear, X_DG, half_v_pad(pad, groove, 1), {}, points);
    detail::gear_on_prism(gear, X_DG, half_v_pad(pad, groove, -1), {}, points);
  }
  detail::emit_reduced_by_axis(points, X_DG.linear().col(2),
                               {X_WD, a, b, SurfacePair::kPadGear, out, true});
}

}  // namespace aprsim::physics
