#include "world/scene/model/free_body.hpp"

#include <algorithm>
#include <cmath>

#include "world/scene/model/part_shapes.hpp"
#include "world/scene/model/pieces.hpp"

namespace aprsim::scene {
namespace {

/// Greatest distance of a standing gear's underside from the tray's top face [m].
constexpr double kStandsOn_m = 5e-3;

FreeBody tray_of(const TrayInstance& tray, const TrayType& type) {
  FreeBody out;
  out.name = tray.name;
  out.type = tray.type;
  out.kind = type.kind;
  out.mass_kg = type.mass_kg;
  out.slab = slab_of(type);
  out.outline = type.outline;
  for (const Slot& slot : type.slots) {
    if (slot.pocket.outline) out.outlined.push_back(slot);
  }
  return out;
}

FreeBody gear_of(const GearInstance& gear, const GearType& type) {
  const GearShapes shapes = shapes_of(type);
  FreeBody out;
  out.name = gear.name;
  out.type = gear.type;
  out.kind = api::BodyKind::kGear;
  out.mass_kg = type.mass_kg;
  out.disc_radius_m = shapes.disc.radius_high;
  out.disc_height_m = shapes.disc.z_high;
  out.peg_radius_m = shapes.peg.radius_high;
  out.peg_top_m = shapes.peg.z_high;
  return out;
}

FreeBody part_of(const PartInstance& part, const PartType& type) {
  FreeBody out;
  out.name = part.name;
  out.type = part.type;
  out.kind = api::BodyKind::kPart;
  out.mass_kg = type.mass_kg;
  out.slab = bounds_of(type.pieces);
  out.pieces = type.pieces;
  return out;
}

}  // namespace

std::vector<FreeBody> free_bodies_of(const Scene& scene) {
  std::vector<FreeBody> bodies;
  for (const auto& tray : scene.trays) {
    bodies.push_back(tray_of(tray, scene.tray_types.at(tray.type)));
  }
  for (const auto& gear : scene.gears) {
    bodies.push_back(gear_of(gear, scene.gear_types.at(gear.type)));
  }
  for (const auto& part : scene.parts) {
    bodies.push_back(part_of(part, scene.part_types.at(part.type)));
  }
  return bodies;
}

bool FreeBody::shows_in_pocket(const Eigen::Vector3d& from_P, const Eigen::Vector3d& p_P) const {
  if (from_P.z() <= 0 || p_P.z() >= 0) return false;
  const Eigen::Vector3d top = p_P + p_P.z() / (p_P.z() - from_P.z()) * (from_P - p_P);
  return std::ranges::any_of(outlined, [&](const Slot& slot) {
    const Outline walls = placed(*slot.pocket.outline, slot.xy, slot.yaw_rad);
    return p_P.z() >= -slot.pocket.depth_m && walls.depth_of(p_P.head<2>()) >= 0 &&
           walls.depth_of(top.head<2>()) >= 0;
  });
}

bool FreeBody::covers(const Eigen::Vector2d& p_P) const {
  if (outline) return outline->depth_of(p_P) >= 0;
  return (p_P.array() >= slab.min().head<2>().array()).all() &&
         (p_P.array() <= slab.max().head<2>().array()).all();
}

bool stands_on(const Eigen::Isometry3d& X_WG, const Eigen::Isometry3d& X_WP, const FreeBody& tray) {
  const Eigen::Vector3d p_P = X_WP.inverse() * X_WG.translation();
  return tray.covers(p_P.head<2>()) && std::abs(p_P.z() - tray.slab.max().z()) <= kStandsOn_m;
}

}  // namespace aprsim::scene
