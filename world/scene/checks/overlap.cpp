#include "world/scene/checks/overlap.hpp"

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

Vector3d prism_support(const PrismSolid& prism, const Vector3d& d) {
  const auto& corners = prism.outline.corners;
  const auto nearer = [&d](const Eigen::Vector2d& p, const Eigen::Vector2d& q) {
    return d.head<2>().dot(p) < d.head<2>().dot(q);
  };
  const Eigen::Vector2d& corner = *std::max_element(corners.begin(), corners.end(), nearer);
  return {corner.x(), corner.y(), std::copysign(prism.half_height, d.z())};
}

Vector3d capsule_support(const CapsuleSolid& capsule, const Vector3d& d) {
  const double norm = d.norm(), scale = norm > 0 ? capsule.radius / norm : 0;
  return Vector3d(0, 0, std::copysign(capsule.half_length, d.z())) + scale * d;
}

Vector3d hull_support(const HullSolid& hull, const Vector3d& d) {
  const auto nearer = [&d](const Vector3d& p, const Vector3d& q) { return d.dot(p) < d.dot(q); };
  return *std::max_element(hull.corners.begin(), hull.corners.end(), nearer);
}

struct Support {
  Vector3d d;
  Vector3d operator()(const BoxSolid& box) const { return box_support(box, d); }
  Vector3d operator()(const FrustumSolid& frustum) const { return frustum_support(frustum, d); }
  Vector3d operator()(const PrismSolid& prism) const { return prism_support(prism, d); }
  Vector3d operator()(const CapsuleSolid& capsule) const { return capsule_support(capsule, d); }
  Vector3d operator()(const HullSolid& hull) const { return hull_support(hull, d); }
};

/// Half the size of a box about the centre that holds the solid.
struct HalfSize {
  Vector3d operator()(const BoxSolid& box) const { return box.half_size; }
  Vector3d operator()(const FrustumSolid& frustum) const {
    const double radius = std::max(frustum.radius_bottom, frustum.radius_top);
    return {radius, radius, frustum.half_height};
  }
  Vector3d operator()(const PrismSolid& prism) const {
    Eigen::Vector2d half = Eigen::Vector2d::Zero();
    for (const auto& corner : prism.outline.corners) half = half.cwiseMax(corner.cwiseAbs());
    return {half.x(), half.y(), prism.half_height};
  }
  Vector3d operator()(const CapsuleSolid& capsule) const {
    return {capsule.radius, capsule.radius, capsule.half_length + capsule.radius};
  }
  Vector3d operator()(const HullSolid& hull) const {
    Vector3d half = Vector3d::Zero();
    for (const Vector3d& corner : hull.corners) half = half.cwiseMax(corner.cwiseAbs());
    return half;
  }
};

/// Overlap measured along one direction: by how far b must move along +d to be past a.
double depth_along(const Solid& a, const Solid& b, const Vector3d& d) {
  return d.dot(a.support(d) - b.support(-d));
}

/// The point of b's box (or bounding box) nearest to a's centre, from a's centre.
Vector3d towards_nearest_corner(const Solid& a, const Solid& b) {
  const Vector3d p_B = b.X_WS.inverse() * a.X_WS.translation();
  const Vector3d half = std::visit(HalfSize{}, b.shape);
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
  for (const Solid* solid : {&a, &b}) {
    if (const auto* hull = std::get_if<HullSolid>(&solid->shape)) {
      for (const Vector3d& n : hull->normals) result.push_back(solid->X_WS.linear() * n);
    }
    const auto* prism = std::get_if<PrismSolid>(&solid->shape);
    if (!prism) continue;
    for (const auto& n : prism->outline.normals) {
      result.push_back(solid->X_WS.linear() * Vector3d(n.x(), n.y(), 0));
    }
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

/// Up to four points of the Minkowski difference b - a.
struct Simplex {
  std::array<Vector3d, 4> points{Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero(),
                                 Vector3d::Zero()};
  int count = 0;
  void add(const Vector3d& point) { points[static_cast<std::size_t>(count++)] = point; }
};

/// Weights, summing to one, of the point of least norm on the affine hull of the points; false if
/// these are not independent. Barycentric coordinates as ratios of areas and volumes: Ericson,
/// Real-Time Collision Detection (2005), 3.4.
bool affine_weights(const Simplex& simplex, std::array<double, 4>& weights) {
  constexpr double kFlat = 1e-15;  // sine below which edges count as parallel
  const Vector3d& origin = simplex.points[0];
  const Vector3d a = simplex.points[1] - origin;
  const Vector3d b = simplex.points[2] - origin;
  const Vector3d c = simplex.points[3] - origin;
  weights = {};
  if (simplex.count == 2) {
    if (a.squaredNorm() == 0) return false;
    weights[1] = -origin.dot(a) / a.squaredNorm();
  } else if (simplex.count == 3) {
    const Vector3d normal = a.cross(b);
    if (normal.norm() <= kFlat * a.norm() * b.norm()) return false;
    weights[1] = b.cross(origin).dot(normal) / normal.squaredNorm();
    weights[2] = origin.cross(a).dot(normal) / normal.squaredNorm();
  } else if (simplex.count == 4) {
    const double volume = a.dot(b.cross(c));
    if (std::abs(volume) <= kFlat * a.norm() * b.norm() * c.norm()) return false;
    weights[1] = -origin.dot(b.cross(c)) / volume;
    weights[2] = -origin.dot(c.cross(a)) / volume;
    weights[3] = -origin.dot(a.cross(b)) / volume;
  }
  weights[0] = 1 - weights[1] - weights[2] - weights[3];
  return true;
}

/// Those of the simplex's points whose bits are set.
Simplex subset(const Simplex& simplex, unsigned members) {
  Simplex result;
  for (int i = 0; i < simplex.count; ++i) {
    if (members >> i & 1u) result.add(simplex.points[static_cast<std::size_t>(i)]);
  }
  return result;
}

/// Reduces the simplex to the points that span its point of least norm, and returns that point.
/// Every subset is tried; there are 15 at the most.
Vector3d nearest_to_origin(Simplex& simplex) {
  Simplex best_points = subset(simplex, 1);
  Vector3d best = simplex.points[0];
  double best_norm = std::numeric_limits<double>::infinity();
  for (unsigned members = 1; members < 1u << simplex.count; ++members) {
    const Simplex points = subset(simplex, members);
    std::array<double, 4> weights{};
    if (!affine_weights(points, weights) || *std::ranges::min_element(weights) < 0) continue;
    Vector3d point = Vector3d::Zero();
    for (std::size_t i = 0; i < weights.size(); ++i) point += weights[i] * points.points[i];
    if (point.norm() >= best_norm) continue;
    best_norm = point.norm();
    best = point;
    best_points = points;
  }
  simplex = best_points;
  return best;
}

/// The descent of Gilbert, Johnson & Keerthi (1988): the point of b - a nearest to the origin gives
/// the direction along which solids that are apart are apart the most.
double depth_by_descent(const Solid& a, const Solid& b, double best) {
  constexpr int kIterations = 64;
  constexpr double kNone = 1e-9;  // [m]
  Simplex simplex;
  Vector3d v = b.X_WS.translation() - a.X_WS.translation();
  for (int i = 0; i < kIterations && best > 0 && v.norm() > kNone; ++i) {
    best = std::min(best, depth_along(a, b, v.normalized()));
    const Vector3d w = b.support(-v) - a.support(v);
    if (simplex.count > 0 && v.dot(v - w) < kNone * v.norm()) break;
    if (simplex.count == 4) break;
    simplex.add(w);
    v = nearest_to_origin(simplex);
  }
  return best;
}

}  // namespace

Vector3d Solid::support(const Vector3d& d_W) const {
  const Vector3d d = X_WS.linear().transpose() * d_W;
  return X_WS * std::visit(Support{d}, shape);
}

double Solid::bounding_radius() const {
  if (const auto* frustum = std::get_if<FrustumSolid>(&shape)) {
    return std::hypot(frustum->half_height, std::max(frustum->radius_bottom, frustum->radius_top));
  }
  return std::visit(HalfSize{}, shape).norm();
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
