#include "world/scene/scene_solids.hpp"

namespace aprsim::scene {
namespace {

constexpr double kBeltThickness = 1e-3;

Solid frustum(const Pose& X_WP, double z_low, double z_high, double r_low, double r_high) {
  return {FrustumSolid{(z_high - z_low) / 2, r_low, r_high},
          X_WP.isometry() * Eigen::Translation3d(0, 0, (z_low + z_high) / 2)};
}

}  // namespace

Solid solid_of(const StaticBox& box) { return {BoxSolid{box.size / 2}, box.X_WS.isometry()}; }

Solid solid_of(const Conveyor& conveyor) {
  return {BoxSolid{{conveyor.length_m / 2, conveyor.width_m / 2, kBeltThickness / 2}},
          conveyor.X_WC.isometry() * Eigen::Translation3d(0, 0, -kBeltThickness / 2)};
}

Solid solid_of(const TrayType& type, const Pose& X_WP) {
  const Eigen::Vector2d size = type.max_xy - type.min_xy, centre = (type.max_xy + type.min_xy) / 2;
  return {BoxSolid{{size.x() / 2, size.y() / 2, type.thickness_m / 2}},
          X_WP.isometry() * Eigen::Translation3d(centre.x(), centre.y(), -type.thickness_m / 2)};
}

std::array<Solid, 3> solids_of(const GearType& type, const Pose& X_WP) {
  return {frustum(X_WP, 0, type.disc_height_m, type.disc_radius_m, type.disc_radius_m),
          frustum(X_WP, type.disc_height_m, type.peg_top_m, type.peg_radius_m, type.peg_radius_m),
          frustum(X_WP, -type.hub_height_m, 0, type.hub_bottom_radius_m, type.hub_top_radius_m)};
}

}  // namespace aprsim::scene
