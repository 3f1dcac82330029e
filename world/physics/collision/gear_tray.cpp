#include <cmath>

#include "world/physics/collision/circle_edge_vs_gear.hpp"
#include "world/physics/collision/gear_vs_prism.hpp"
#include "world/physics/collision/narrow_phase.hpp"

namespace aprsim::physics {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// Pockets that one gear can reach at once.
constexpr int kMaxNearPockets = 8;

struct NearPockets {
  std::array<detail::PocketProfile, kMaxNearPockets> items;
  std::size_t count = 0;
};

/// The pockets whose mouth the gear's bounding sphere overlaps, in the tray's order.
void find_near_pockets(const detail::GearShape& gear, const Isometry3d& X_PG,
                       const scene::TrayType& tray, NearPockets& near) {
  const Vector3d centre = X_PG * Vector3d(0, 0, 0.5 * (gear.z_low + gear.z_high));
  const double radius = std::hypot(gear.r_max, 0.5 * (gear.z_high - gear.z_low));
  for (const scene::Slot& slot : tray.slots) {
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
  touch(pocket.r_mouth, 0);
  if (pocket.chamfered()) touch(pocket.r_edge, pocket.z_edge);
}

}  // namespace

void gear_tray(const scene::GearType& gear, const Isometry3d& X_WG, const scene::TrayType& tray,
               const Isometry3d& X_WP, BodyIndex a, BodyIndex b, std::vector<Contact>& out) {
  const Isometry3d X_PG = X_WP.inverse(Eigen::Isometry) * X_WG;
  const detail::GearShape shape = detail::gear_shape(gear);
  const detail::Prism slab = detail::box_prism(
      {tray.min_xy.x(), tray.min_xy.y(), -tray.thickness_m}, {tray.max_xy.x(), tray.max_xy.y(), 0});
  NearPockets near;
  find_near_pockets(shape, X_PG, tray, near);
  const std::span<const detail::PocketProfile> pockets(near.items.data(), near.count);
  detail::Candidates points;
  if (!detail::gear_on_prism(shape, X_PG, slab, pockets, points)) return;
  for (const detail::PocketProfile& pocket : pockets) mouth_on_gear(shape, X_PG, pocket, points);
  detail::emit_reduced_by_axis(points, X_PG.linear().col(2),
                               {X_WP, a, b, SurfacePair::kGearTray, out});
}

}  // namespace aprsim::physics
