#include "world/scene/checks/scene_solids.hpp"

#include <utility>

#include "world/scene/model/part_shapes.hpp"

namespace aprsim::scene {
namespace {

constexpr double kBeltThickness = 1e-3;

Solid solid_of(const Frustum& frustum, const Eigen::Isometry3d& X_WP) {
  return {
      FrustumSolid{(frustum.z_high - frustum.z_low) / 2, frustum.radius_low, frustum.radius_high},
      X_WP * Eigen::Translation3d(0, 0, (frustum.z_low + frustum.z_high) / 2)};
}

}  // namespace

Solid solid_of(const StaticBox& box) { return {BoxSolid{box.size / 2}, box.X_WS.isometry()}; }

Solid solid_of(const Conveyor& conveyor) {
  return {BoxSolid{{conveyor.length_m / 2, conveyor.width_m / 2, kBeltThickness / 2}},
          conveyor.X_WC.isometry() * Eigen::Translation3d(0, 0, -kBeltThickness / 2)};
}

Solid solid_of(const TrayType& type, const Pose& X_WP) {
  const Eigen::AlignedBox3d slab = slab_of(type);
  if (type.outline) {
    PrismSolid prism{*type.outline, type.thickness_m / 2};
    for (auto& corner : prism.outline.corners) corner -= slab.center().head<2>();
    return {std::move(prism), X_WP.isometry() * Eigen::Translation3d(slab.center())};
  }
  return {BoxSolid{slab.sizes() / 2}, X_WP.isometry() * Eigen::Translation3d(slab.center())};
}

std::array<Solid, 3> solids_of(const GearType& type, const Pose& X_WP) {
  const GearShapes gear = shapes_of(type);
  const Eigen::Isometry3d X = X_WP.isometry();
  return {solid_of(gear.disc, X), solid_of(gear.peg, X), solid_of(gear.hub, X)};
}

}  // namespace aprsim::scene
