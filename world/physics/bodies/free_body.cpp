#include "world/physics/bodies/free_body.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "world/physics/bodies/material_table.hpp"
#include "world/physics/collision/speculative/speculative_contacts.hpp"
#include "world/scene/model/part_shapes.hpp"
#include "world/scene/model/pieces.hpp"

namespace aprsim::physics {
namespace {

/// A solid of revolution about z, between two heights, is bounded along each world axis by its
/// half length and the projection of its rim.
Aabb aabb_of_gear(const scene::GearType& gear, const Eigen::Isometry3d& X_WG) {
  const double low = -gear.hub_height_m;
  const double high = std::max(gear.disc_height_m, gear.peg_top_m);
  const Eigen::Vector3d centre = X_WG * Eigen::Vector3d(0, 0, 0.5 * (low + high));
  const double radius = std::max(gear.disc_radius_m, gear.hub_top_radius_m);
  Eigen::Vector3d reach;
  for (int axis = 0; axis < 3; ++axis) {
    const double c = X_WG.linear()(axis, 2);
    // Tight bounds of a cylinder: its disc projects to r sqrt(1 - c^2) on an axis at cosine c.
    reach[axis] = 0.5 * (high - low) * std::abs(c) + radius * std::sqrt(std::max(0.0, 1 - c * c));
  }
  return {centre - reach, centre + reach};
}

/// Largest distance of a rim from the centre of mass.
double gear_radius(const scene::GearType& gear, const Eigen::Vector3d& com) {
  const double disc =
      std::hypot(gear.disc_radius_m, std::max(std::abs(com.z()), gear.disc_height_m - com.z()));
  const double peg = std::hypot(gear.peg_radius_m, gear.peg_top_m - com.z());
  const double hub = std::hypot(gear.hub_top_radius_m, com.z() + gear.hub_height_m);
  return std::max({disc, peg, hub});
}

/// A tray's slab lies under z = 0 of its frame.
FreeBody make_tray(const scene::TrayInstance& instance, const scene::TrayType& type,
                   double step_s) {
  FreeBody free;
  free.step_s = step_s;
  free.name = instance.name;
  free.tray = &type;
  free.mass = tray_mass(type);
  free.origin_B = free.mass.com;
  const Eigen::AlignedBox3d slab = scene::slab_of(type);
  free.slab_size = slab.sizes();
  free.X_BS.translation() = slab.center();
  // A corner of the box around the slab is farthest from the centre of mass.
  free.radius_m = 0.5 * free.slab_size.norm() + (free.mass.com - free.X_BS.translation()).norm();
  free.set_carried_mass(free.mass);
  free.place(instance.X_WP.isometry(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero());
  return free;
}

FreeBody make_gear(const scene::GearInstance& instance, const scene::GearType& type,
                   double step_s) {
  FreeBody free;
  free.step_s = step_s;
  free.name = instance.name;
  free.gear = &type;
  free.gear_shape = type;
  free.mass = gear_mass(type);
  free.origin_B = free.mass.com;
  free.radius_m = gear_radius(type, free.mass.com);
  free.set_carried_mass(free.mass);
  free.place(instance.X_WP.isometry(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero());
  return free;
}

FreeBody make_part(const scene::PartInstance& instance, const scene::PartType& type,
                   std::shared_ptr<const PartShape> shape, double step_s) {
  FreeBody free;
  free.step_s = step_s;
  free.name = instance.name;
  free.mass = {type.mass_kg, type.com, type.inertia};
  free.origin_B = free.mass.com;
  const Eigen::AlignedBox3d box = scene::bounds_of(type.pieces);
  free.slab_size = box.sizes();
  free.X_BS.translation() = box.center();
  for (const ConvexPiece& piece : shape->pieces) {
    const Eigen::Vector3d com_P = piece.X_BP().inverse() * free.mass.com;
    free.radius_m = std::max(free.radius_m, piece.farthest(com_P));
  }
  free.part = std::move(shape);
  free.set_carried_mass(free.mass);
  free.place(instance.X_WP.isometry(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero());
  return free;
}

Aabb aabb_of_part(const FreeBody& free) {
  const auto& pieces = free.part->pieces;
  Aabb bounds = pieces.front().bounds(free.X_WB * pieces.front().X_BP());
  for (const ConvexPiece& piece : std::span(pieces).subspan(1)) {
    bounds = bounds.joined(piece.bounds(free.X_WB * piece.X_BP()));
  }
  return bounds;
}

/// The radius bounds the fingers at any opening.
FreeBody make_tool(const scene::Tool& tool) {
  FreeBody free;
  free.name = tool.name;
  free.tool.emplace(tool);
  free.mass = tool_mass(tool.gripper);
  free.origin_B = free.mass.com;
  for (const scene::Block& block : free.tool->blocks()) {
    free.radius_m =
        std::max(free.radius_m, (block.centre - free.mass.com).norm() + 0.5 * block.size.norm());
  }
  free.set_carried_mass(free.mass);
  free.place(tool.X_WQ.isometry() * tool.X_QT.isometry(), Eigen::Vector3d::Zero(),
             Eigen::Vector3d::Zero());
  return free;
}

Aabb aabb_of_tool(const FreeBody& free) {
  const auto blocks = free.tool->blocks();
  Aabb bounds = aabb_of_box(blocks[0].size, free.X_WS(blocks[0]));
  for (const scene::Block& block : blocks.subspan(1)) {
    bounds = bounds.joined(aabb_of_box(block.size, free.X_WS(block)));
  }
  return bounds;
}

}  // namespace

PartShape::PartShape(const scene::PartType& type) {
  for (const api::Piece& piece : type.pieces) pieces.emplace_back(piece);
}

void FreeBody::refresh() {
  // The rigid body's origin is the centre of mass; the scene's frame B is elsewhere.
  X_WB.linear() = body.R_WB();
  X_WB.translation() = body.p_W() - X_WB.linear() * origin_B;
  omega_W = body.omega_W();
  v_com_W = body.v_W();
  // A composite's origin is the centre of mass of the whole.
  if (origin_B != mass.com) v_com_W += omega_W.cross(X_WB.linear() * (mass.com - origin_B));
  update_bounds();
}

void FreeBody::place(const Eigen::Isometry3d& X_WB_new, const Eigen::Vector3d& v_com,
                     const Eigen::Vector3d& omega) {
  X_WB = X_WB_new;
  v_com_W = v_com;
  omega_W = omega;
  body.set_orientation(Eigen::Matrix3d(X_WB.linear()));
  body.set_position(origin_W());
  body.set_velocity(velocity_at(origin_W()), omega);
  update_bounds();
}

void FreeBody::set_carried_mass(const MassProperties& all) {
  body.set_mass(all.mass_kg, all.inertia);
  // The new centre of mass moves as the material point there did.
  origin_B = all.com;
  body.set_position(origin_W());
  // Linear and angular momentum about the old origin are not conserved here. Bodies merge at rest
  // to each other, where the change is within the drift that merging allows.
  body.set_velocity(velocity_at(origin_W()), omega_W);
}

void FreeBody::update_bounds() {
  if (is_tool()) {
    bounds = aabb_of_tool(*this);
  } else if (is_part()) {
    bounds = aabb_of_part(*this);
  } else {
    bounds = is_tray() ? aabb_of_box(slab_size, X_WS()) : aabb_of_gear(*gear, X_WB);
  }
  // Speculative contacts are searched this far ahead, so that the broad phase must reach as far.
  bounds = bounds.grown(kLookaheadSteps * step_s * (v_com_W.norm() + radius_m * omega_W.norm()));
}

std::vector<FreeBody> make_free_bodies(const scene::Scene& scene,
                                       std::span<const scene::Tool> tools) {
  std::vector<FreeBody> bodies;
  bodies.reserve(scene.trays.size() + scene.gears.size() + scene.parts.size() + tools.size());
  for (const auto& tray : scene.trays) {
    bodies.push_back(make_tray(tray, scene.tray_types.at(tray.type), scene.physics.step_s));
  }
  for (const auto& gear : scene.gears) {
    bodies.push_back(make_gear(gear, scene.gear_types.at(gear.type), scene.physics.step_s));
  }
  const MaterialTable materials(scene);
  std::map<std::string, std::shared_ptr<const PartShape>> shapes;
  for (const auto& part : scene.parts) {
    const scene::PartType& type = scene.part_types.at(part.type);
    auto& shape = shapes[part.type];
    if (!shape) {
      auto made = std::make_shared<PartShape>(type);
      made->material = materials.number_of(type.material);
      shape = std::move(made);
    }
    bodies.push_back(make_part(part, type, shape, scene.physics.step_s));
  }
  for (const auto& tool : tools) bodies.push_back(make_tool(tool));
  return bodies;
}

}  // namespace aprsim::physics
