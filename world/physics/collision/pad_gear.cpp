#include <algorithm>
#include <cmath>

#include "world/physics/collision/gear_vs_prism.hpp"
#include "world/physics/collision/narrow_phase.hpp"

namespace aprsim::physics {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Half of a V pad: convex, joined to the other half at x = 0. side = +1 for x > 0, -1 for x < 0.
detail::Prism half_v(const Pad& pad, double groove_depth, double side) {
  const double half = 0.5 * pad.width_m, back = -pad.depth_m;
  const double mouth = groove_depth * std::tan(pad.v_half_angle_rad);
  const double c = std::cos(pad.v_half_angle_rad), s = std::sin(pad.v_half_angle_rad);
  detail::Prism prism;
  prism.sides = 5;
  const Vector2d rear(0, back), corner(side * half, back), front(side * half, 0),
      rim(side * mouth, 0), apex(0, -groove_depth);
  const Vector2d to_rear(0, -1), outside(side, 0), face(0, 1), groove(-side * c, s),
      joint(-side, 0);
  if (side > 0) {
    prism.v = {rear, corner, front, rim, apex};
    prism.n = {to_rear, outside, face, groove, joint};
    prism.internal[4] = true;
  } else {
    prism.v = {rear, apex, rim, front, corner};
    prism.n = {joint, groove, face, outside, to_rear};
    prism.internal[0] = true;
  }
  prism.z0 = 0;
  prism.z1 = pad.height_m;
  const Vector2d middle = 0.2 * (rear + corner + front + rim + apex);
  prism.middle << middle, 0.5 * pad.height_m;
  return prism;
}

}  // namespace

double v_groove_depth(const Pad& pad, double peg_radius_m) {
  constexpr double kInside = 1.05, kOfHalfWidth = 0.98, kOfDepth = 0.8;
  const double tangent = std::tan(pad.v_half_angle_rad);
  const double wanted = pad.v_depth_m > 0
                            ? pad.v_depth_m
                            : kInside * peg_radius_m * std::cos(pad.v_half_angle_rad) / tangent;
  return std::min({wanted, kOfHalfWidth * 0.5 * pad.width_m / tangent, kOfDepth * pad.depth_m});
}

double holding_gap(const Pad& pad, double peg_radius_m) {
  if (pad.shape == scene::PadShape::kFlat) return 2 * peg_radius_m;
  const double to_apex = peg_radius_m / std::sin(pad.v_half_angle_rad);
  return 2 * (to_apex - v_groove_depth(pad, peg_radius_m));
}

void pad_gear(const Pad& pad, const Eigen::Isometry3d& X_WD, const scene::GearType& gear,
              const Eigen::Isometry3d& X_WG, BodyIndex a, BodyIndex b, std::vector<Contact>& out) {
  const Eigen::Isometry3d X_DG = X_WD.inverse(Eigen::Isometry) * X_WG;
  const detail::GearShape shape = detail::gear_shape(gear);
  detail::Candidates points;
  if (pad.shape == scene::PadShape::kFlat) {
    const double half = 0.5 * pad.width_m;
    detail::gear_on_prism(shape, X_DG,
                          detail::box_prism({-half, -pad.depth_m, 0}, {half, 0, pad.height_m}), {},
                          points);
  } else {
    const double groove = v_groove_depth(pad, gear.peg_radius_m);
    detail::gear_on_prism(shape, X_DG, half_v(pad, groove, 1), {}, points);
    detail::gear_on_prism(shape, X_DG, half_v(pad, groove, -1), {}, points);
  }
  detail::emit_reduced_by_axis(points, X_DG.linear().col(2),
                               {X_WD, a, b, SurfacePair::kPadGear, out, true});
}

}  // namespace aprsim::physics
