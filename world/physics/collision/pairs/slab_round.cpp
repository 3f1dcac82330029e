#include <algorithm>
#include <array>
#include <cmath>

#include "world/physics/collision/pairs/gear_vs_prism.hpp"
#include "world/physics/collision/pairs/narrow_phase.hpp"
#include "world/physics/collision/shapes/nearness.hpp"

// Round solids against slabs: a cylinder is a gear of one disc; a capsule is all that lies within a
// radius of a segment.
namespace aprsim::physics {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

detail::Prism prism_of(const SlabShape& slab) {
  const Vector3d half = 0.5 * slab.size;
  detail::Prism prism = detail::box_prism(-half, half);
  if (!slab.outline) return prism;
  prism.set_sides(slab.outline->corners, slab.outline->normals);
  for (std::size_t i = 0; i < slab.outline->corners.size(); ++i) {
    prism.v[i] -= slab.middle;
    prism.off[i] = prism.n[i].dot(prism.v[i]);
  }
  return prism;
}

}  // namespace

void slab_cylinder(const SlabShape& slab, const Isometry3d& X_WS, double radius_m, double length_m,
                   const Isometry3d& X_WC, BodyIndex a, BodyIndex b, SurfacePair pair,
                   std::vector<Contact>& out) {
  scene::GearType disc;
  disc.disc_radius_m = radius_m;
  disc.disc_height_m = length_m;
  const Isometry3d X_SG =
      X_WS.inverse(Eigen::Isometry) * X_WC * Eigen::Translation3d(0, 0, -0.5 * length_m);
  detail::Candidates points;
  if (!detail::gear_on_prism(disc, X_SG, prism_of(slab), {}, points)) return;
  detail::emit_reduced_by_axis(points, X_SG.linear().col(2), {X_WS, a, b, pair, out, true});
}

void slab_capsule(const SlabShape& slab, const Isometry3d& X_WS, double radius_m, double length_m,
                  const Isometry3d& X_WC, BodyIndex a, BodyIndex b, SurfacePair pair,
                  std::vector<Contact>& out) {
  const detail::Prism prism = prism_of(slab);
  const Isometry3d X_SC = X_WS.inverse(Eigen::Isometry) * X_WC;
  const Vector3d middle = X_SC.translation(), half = 0.5 * length_m * X_SC.linear().col(2);
  const auto at = [&](double t) { return nearness(prism, middle + t * half); };
  // The distance along the segment is convex: golden section search (Press et al. 2007, sec. 10.2).
  constexpr double kGolden = 0.6180339887498949, kSame = 1e-7;
  double low = -1, high = 1;
  while (length_m > 0 && high - low > kSame) {
    const double m0 = high - kGolden * (high - low), m1 = low + kGolden * (high - low);
    if (at(m0).distance < at(m1).distance) {
      high = m1;
    } else {
      low = m0;
    }
  }
  detail::Candidates points;
  const auto touch = [&](double t) {
    const detail::Nearness near = at(t);
    points.add(middle + t * half - radius_m * near.out, near.out, radius_m - near.distance);
  };
  touch(0.5 * (low + high));
  if (length_m > 0) touch(-1);
  if (length_m > 0) touch(1);
  detail::emit_reduced(points, {X_WS, a, b, pair, out, true});
}

}  // namespace aprsim::physics
