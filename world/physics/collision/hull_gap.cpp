#include "world/physics/collision/hull_gap.hpp"

#include <algorithm>
#include <cmath>

namespace aprsim::physics {
namespace {

using detail::GearShape;
using Eigen::Isometry3d;
using Eigen::Vector3d;

/// Half of what the cylinder about a gear extends along a direction with that cosine to its axis.
double reach(const GearShape& gear, double cosine) {
  return 0.5 * (gear.z_high - gear.z_low) * std::abs(cosine) +
         gear.r_max * std::sqrt(std::max(0.0, 1 - cosine * cosine));
}

}  // namespace

/// Along either axis, and along the line between their middles.
double gear_gear_gap(const GearShape& gear_a, const Isometry3d& X_WA, const GearShape& gear_b,
                     const Isometry3d& X_WB) {
  const Vector3d d = X_WA * gear_a.middle() - X_WB * gear_b.middle();
  const Vector3d u_a = X_WA.linear().col(2), u_b = X_WB.linear().col(2);
  const double distance = d.norm(), along_a = d.dot(u_a), along_b = d.dot(u_b);
  const double cosine = u_a.dot(u_b);
  const auto gap = [&](double way, double cosine_a, double cosine_b) {
    return std::abs(way) - reach(gear_a, cosine_a) - reach(gear_b, cosine_b);
  };
  const double by_axes = std::max(gap(along_a, 1, cosine), gap(along_b, cosine, 1));
  if (distance == 0) return by_axes;
  return std::max(by_axes, gap(distance, along_a / distance, along_b / distance));
}

double gear_box_gap(const GearShape& gear, const Isometry3d& X_WG, const Vector3d& size,
                    const Isometry3d& X_WS) {
  const Vector3d d_W = X_WG * gear.middle() - X_WS.translation(), u_W = X_WG.linear().col(2);
  const Vector3d d = X_WS.linear().transpose() * d_W, u = X_WS.linear().transpose() * u_W;
  double gap = std::abs(d.dot(u)) - 0.5 * (gear.z_high - gear.z_low) - 0.5 * size.dot(u.cwiseAbs());
  for (int axis = 0; axis < 3; ++axis) {
    gap = std::max(gap, std::abs(d(axis)) - 0.5 * size(axis) - reach(gear, u(axis)));
  }
  return gap;
}

double box_box_gap(const Vector3d& size_a, const Isometry3d& X_WA, const Vector3d& size_b,
                   const Isometry3d& X_WB) {
  const Eigen::Matrix3d cosines = (X_WA.linear().transpose() * X_WB.linear()).cwiseAbs();
  const Vector3d d_W = X_WB.translation() - X_WA.translation();
  const Vector3d d_a = (X_WA.linear().transpose() * d_W).cwiseAbs();
  const Vector3d d_b = (X_WB.linear().transpose() * d_W).cwiseAbs();
  const Vector3d gap_a = d_a - 0.5 * (size_a + cosines * size_b);
  const Vector3d gap_b = d_b - 0.5 * (size_b + cosines.transpose() * size_a);
  return std::max(gap_a.maxCoeff(), gap_b.maxCoeff());
}

}  // namespace aprsim::physics
