#include "world/scene/overlap.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace aprsim::scene {
namespace {

using Eigen::Vector3d;

Vector3d box_support(const BoxSolid& box, const Vector3d& d) {
  return {std::copysign(box.half_size.x(), d.x()), std::copysign(box.half_size.y(), d.y()),
          std::copysign(box.half_size.z(), d.z())};
}

Vector3d frustum_support(const FrustumSolid& frustum, const Vector3d& d) {
  const double lateral = std::hypot(d.x(), d.y());
  const double top = frustum.radius_top * lateral + frustum.half_height * d.z();
  const double bottom = frustum.radius_bottom * lateral - frustum.half_height * d.z();
  const bool upper = top >= bottom;
  const double radius = upper ? frustum.radius_top : frustum.radius_bottom;
  const double scale = lateral > 0 ? radius / lateral : 0;
  return {d.x() * scale, d.y() * scale, upper ? frustum.half_height : -frustum.half_height};
}

/// Overlap measured along one direction: by how far b must move along +d to be past a.
double depth_along(const Solid& a, const Solid& b, const Vector3d& d) {
  return d.dot(a.support(d) - b.support(-d));
}

/// The point of b's box (or bounding box) nearest to a's centre, from a's centre.
Vector3d towards_nearest_corner(const Solid& a, const Solid& b) {
  const Vector3d p_B = b.X_WS.inverse() * a.X_WS.translation();
  Vector3d half;
  if (const auto* box = std::get_if<BoxSolid>(&b.shape)) {
    half = box->half_size;
  } else {
    const auto& frustum = std::get<FrustumSolid>(b.shape);
    const double radius = std::max(frustum.radius_bottom, frustum.radius_top);
    half = {radius, radius, frustum.half_height};
  }
  return b.X_WS * p_B.cwiseMax(-half).cwiseMin(half) - a.X_WS.translation();
}

std::vector<Vector3d> candidate_directions(const Solid& a, const Solid& b) {
  std::vector<Vector3d> result;
  const Eigen::Matrix3d axes_a = a.X_WS.linear(), axes_b = b.X_WS.linear();
  for (int i = 0; i < 3; ++i) {
    result.push_back(axes_a.col(i));
    result.push_back(axes_b.col(i));
    for (int j = 0; j < 3; ++j) result.push_back(axes_a.col(i).cross(axes_b.col(j)));
  }
  const Vector3d between = b.X_WS.translation() - a.X_WS.translation();
  for (const Vector3d& d :
       {between, towards_nearest_corner(a, b), Vector3d(-towards_nearest_corner(b, a))}) {
    result.push_back(d);
    for (const Vector3d& axis : {Vector3d(axes_a.col(2)), Vector3d(axes_b.col(2))}) {
      result.push_back(d - axis * axis.dot(d));
    }
  }
  return result;
}

/// Frank-Wolfe on the Minkowski difference: its point nearest to the origin points along the
/// direction that parts solids that are apart.
double depth_by_descent(const Solid& a, const Solid& b, double best) {
  constexpr int kIterations = 300;
  Vector3d v = b.X_WS.translation() - a.X_WS.translation();
  for (int i = 0; i < kIterations && best > 0; ++i) {
    const double length = v.norm();
    if (length < 1e-9) break;
    best = std::min(best, depth_along(a, b, v / length));
    const Vector3d step = b.support(-v) - a.support(v) - v;
    const double squared = step.squaredNorm();
    if (squared < 1e-18) break;
    v += step * std::clamp(-v.dot(step) / squared, 0.0, 1.0);
  }
  return best;
}

}  // namespace

Vector3d Solid::support(const Vector3d& d_W) const {
  const Vector3d d = X_WS.linear().transpose() * d_W;
  const auto* box = std::get_if<BoxSolid>(&shape);
  return X_WS * (box ? box_support(*box, d) : frustum_support(std::get<FrustumSolid>(shape), d));
}

double Solid::bounding_radius() const {
  if (const auto* box = std::get_if<BoxSolid>(&shape)) return box->half_size.norm();
  const auto& frustum = std::get<FrustumSolid>(shape);
  return std::hypot(frustum.half_height, std::max(frustum.radius_bottom, frustum.radius_top));
}

double overlap_depth(const Solid& a, const Solid& b) {
  const Vector3d between = b.X_WS.translation() - a.X_WS.translation();
  const double reach = a.bounding_radius() + b.bounding_radius();
  if (between.squaredNorm() > reach * reach) return reach - between.norm();
  double best = std::numeric_limits<double>::infinity();
  for (const Vector3d& candidate : candidate_directions(a, b)) {
    const double length = candidate.norm();
    if (length < 1e-9) continue;
    const Vector3d d = candidate / length;
    best = std::min({best, depth_along(a, b, d), depth_along(a, b, -d)});
  }
  return depth_by_descent(a, b, best);
}

double depth_below_ground(const Solid& solid) { return -solid.support(-Vector3d::UnitZ()).z(); }

}  // namespace aprsim::scene
