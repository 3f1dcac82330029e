#include "world/physics/collision/speculative/hull_gap.hpp"

#include <algorithm>
#include <cmath>

// A lower bound of the distance of two convex hulls: the largest separation over a few candidate
// axes (separating axes: Gottschalk, Lin & Manocha 1996; Ericson 2005, ch. 4.4 and 5.2.1). The
// bound need not be tight; it gives the distance ahead without contact, and which body lies
// on which.
namespace aprsim::physics {
namespace {

using detail::GearShape;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Half extent of the cylinder about a gear along a direction with this cosine to its axis.
double reach(const GearShape& gear, double cosine) {
  return 0.5 * (gear.z_high - gear.z_low) * std::abs(cosine) +
         gear.r_max * std::sqrt(std::max(0.0, 1 - cosine * cosine));
}

/// Tests an axis. `distance`: from the second middle to the first along it; `reaches`: sum of both
/// half extents.
void test_axis(const Vector3d& axis_W, double distance, double reaches, HullGap& gap) {
  // Positive: the slab between the projections separates the hulls. Negative: their overlap along
  // the axis.
  const double m = std::abs(distance) - reaches;
  if (m <= gap.m) return;
  gap.m = m;
  gap.n_W = distance < 0 ? Vector3d(-axis_W) : axis_W;
}

}  // namespace

HullGap gear_gear_gap(const GearShape& gear_a, const Isometry3d& X_WA, const GearShape& gear_b,
                      const Isometry3d& X_WB) {
  // The line between the middles is the axis of two spheres. It separates gears that lie beside
  // each other at any angle, where neither of their axes does.
  const Vector3d d = X_WA * gear_a.middle() - X_WB * gear_b.middle();
  const Vector3d u_a = X_WA.linear().col(2), u_b = X_WB.linear().col(2);
  const double distance = d.norm(), along_a = d.dot(u_a), along_b = d.dot(u_b);
  const double cosine = u_a.dot(u_b);
  HullGap gap;
  test_axis(u_a, along_a, reach(gear_a, 1) + reach(gear_b, cosine), gap);
  test_axis(u_b, along_b, reach(gear_a, cosine) + reach(gear_b, 1), gap);
  if (distance == 0) return gap;
  test_axis(d / distance, distance,
            reach(gear_a, along_a / distance) + reach(gear_b, along_b / distance), gap);
  return gap;
}

HullGap gear_box_gap(const GearShape& gear, const Isometry3d& X_WG, const Vector3d& size,
                     const Isometry3d& X_WS) {
  const Matrix3d& R_WS = X_WS.linear();
  const Vector3d d_W = X_WG * gear.middle() - X_WS.translation(), u_W = X_WG.linear().col(2);
  const Vector3d d = R_WS.transpose() * d_W, u = R_WS.transpose() * u_W;
  HullGap gap;
  test_axis(u_W, d.dot(u), reach(gear, 1) + 0.5 * size.dot(u.cwiseAbs()), gap);
  for (int i = 0; i < 3; ++i) {
    test_axis(R_WS.col(i), d(i), 0.5 * size(i) + reach(gear, u(i)), gap);
  }
  return gap;
}

HullGap box_box_gap(const Vector3d& size_a, const Isometry3d& X_WA, const Vector3d& size_b,
                    const Isometry3d& X_WB) {
  const Matrix3d &R_WA = X_WA.linear(), &R_WB = X_WB.linear();
  // Six face axes of the fifteen: cross products of edges would sharpen the bound only for boxes
  // edge on edge.
  const Matrix3d cosines = (R_WA.transpose() * R_WB).cwiseAbs();
  const Vector3d d_W = X_WA.translation() - X_WB.translation();
  HullGap gap;
  for (int i = 0; i < 3; ++i) {
    const Vector3d axis_a = R_WA.col(i), axis_b = R_WB.col(i);
    test_axis(axis_a, d_W.dot(axis_a), 0.5 * (size_a(i) + cosines.row(i).dot(size_b)), gap);
    test_axis(axis_b, d_W.dot(axis_b), 0.5 * (size_b(i) + cosines.col(i).dot(size_a)), gap);
  }
  return gap;
}

}  // namespace aprsim::physics
