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

/// Up to four points of the Minkowski difference b - a.
struct Simplex {
  std::array<Vector3d, 4> points;
  int count = 0;
};

/// Weights, summing to one, of the point of least norm on the affine hull of some of the points;
/// false if these are not independent.
bool affine_weights(const Simplex& simplex, unsigned members, Eigen::Vector4d& weights) {
  std::array<int, 4> index{};
  int count = 0;
  for (int i = 0; i < simplex.count; ++i) {
    if (members >> i & 1u) index[static_cast<std::size_t>(count++)] = i;
  }
  const Vector3d origin = simplex.points[static_cast<std::size_t>(index[0])];
  Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, 3> edges(3, count - 1);
  for (int i = 1; i < count; ++i) {
    edges.col(i - 1) =
        simplex.points[static_cast<std::size_t>(index[static_cast<std::size_t>(i)])] - origin;
  }
  weights.setZero();
  Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 3, 1> along(count - 1);
  if (count > 1) {
    const auto solver = edges.colPivHouseholderQr();
    if (solver.rank() < count - 1) return false;
    along = solver.solve(-origin);
  }
  weights[index[0]] = 1 - along.sum();
  for (int i = 1; i < count; ++i) weights[index[static_cast<std::size_t>(i)]] = along[i - 1];
  return true;
}

/// Reduces the simplex to the points that span its point of least norm, and returns that point.
Vector3d nearest_to_origin(Simplex& simplex) {
  Vector3d best = simplex.points[0];
  unsigned best_members = 1;
  double best_norm = std::numeric_limits<double>::infinity();
  for (unsigned members = 1; members < 1u << simplex.count; ++members) {
    Eigen::Vector4d weights;
    if (!affine_weights(simplex, members, weights) || weights.minCoeff() < 0) continue;
    Vector3d point = Vector3d::Zero();
    for (int i = 0; i < simplex.count; ++i) {
      point += weights[i] * simplex.points[static_cast<std::size_t>(i)];
    }
    if (point.norm() >= best_norm) continue;
    best_norm = point.norm();
    best = point;
    best_members = members;
  }
  int kept = 0;
  for (int i = 0; i < simplex.count; ++i) {
    if (best_members >> i & 1u) {
      simplex.points[static_cast<std::size_t>(kept++)] =
          simplex.points[static_cast<std::size_t>(i)];
    }
  }
  simplex.count = kept;
  return best;
}

/// The GJK descent: the point of b - a nearest to the origin gives the direction along which solids
/// that are apart are apart the most.
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
    simplex.points[static_cast<std::size_t>(simplex.count++)] = w;
    v = nearest_to_origin(simplex);
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
