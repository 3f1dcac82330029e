#include "world/robot/avoidance/convex_shape.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <variant>

namespace aprsim::robot {
namespace {

constexpr int kMostIterations = 48;
constexpr double kTolerance_m = 1e-5;
constexpr double kTouching_m = 1e-9;
constexpr double kDegenerate = 1e-30;

/// Up to four points of the difference of two shapes.
struct Simplex {
  std::array<Eigen::Vector3d, 4> points;
  int count = 0;

  void keep(std::initializer_list<int> which) {
    std::array<Eigen::Vector3d, 4> kept;
    int n = 0;
    for (const int i : which) kept[static_cast<std::size_t>(n++)] = at(i);
    points = kept;
    count = n;
  }
  [[nodiscard]] const Eigen::Vector3d& at(int i) const {
    return points[static_cast<std::size_t>(i)];
  }
};

/// The point of a line segment nearest to the origin. Reduces the simplex to its feature.
Eigen::Vector3d nearest_on_segment(Simplex& s, int i, int j) {
  const Eigen::Vector3d a = s.at(i), ab = s.at(j) - a;
  const double along = -a.dot(ab), length = ab.squaredNorm();
  if (along <= 0 || length < kDegenerate) {
    s.keep({i});
    return a;
  }
  if (along >= length) {
    const Eigen::Vector3d b = s.at(j);
    s.keep({j});
    return b;
  }
  s.keep({i, j});
  return a + along / length * ab;
}

/// The same of a triangle, by its Voronoi regions (Ericson 2005, sec. 5.1.5).
Eigen::Vector3d nearest_on_triangle(Simplex& s, int i, int j, int k) {
  const Eigen::Vector3d a = s.at(i), b = s.at(j), c = s.at(k);
  const Eigen::Vector3d ab = b - a, ac = c - a;
  const double d1 = -ab.dot(a), d2 = -ac.dot(a);
  if (d1 <= 0 && d2 <= 0) {
    s.keep({i});
    return a;
  }
  const double d3 = -ab.dot(b), d4 = -ac.dot(b);
  if (d3 >= 0 && d4 <= d3) {
    s.keep({j});
    return b;
  }
  const double d5 = -ab.dot(c), d6 = -ac.dot(c);
  if (d6 >= 0 && d5 <= d6) {
    s.keep({k});
    return c;
  }
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return nearest_on_segment(s, i, j);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return nearest_on_segment(s, i, k);
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return nearest_on_segment(s, j, k);
  const double sum = va + vb + vc;
  if (std::abs(sum) < kDegenerate) return nearest_on_segment(s, i, j);
  s.keep({i, j, k});
  return a + vb / sum * ab + vc / sum * ac;
}

/// The same of a tetrahedron; the origin where that is inside.
Eigen::Vector3d nearest_on_tetrahedron(Simplex& s) {
  constexpr int kFaces[4][4] = {{0, 1, 2, 3}, {0, 1, 3, 2}, {0, 2, 3, 1}, {1, 2, 3, 0}};
  Simplex nearest;
  Eigen::Vector3d v = Eigen::Vector3d::Zero();
  double least = std::numeric_limits<double>::infinity();
  for (const auto& face : kFaces) {
    const Eigen::Vector3d& a = s.at(face[0]);
    const Eigen::Vector3d normal = (s.at(face[1]) - a).cross(s.at(face[2]) - a);
    const double origin = -a.dot(normal), opposite = (s.at(face[3]) - a).dot(normal);
    // A flat tetrahedron has no inside.
    if (origin * opposite > 0) continue;
    Simplex reduced = s;
    const Eigen::Vector3d point = nearest_on_triangle(reduced, face[0], face[1], face[2]);
    if (point.squaredNorm() >= least) continue;
    least = point.squaredNorm();
    nearest = reduced;
    v = point;
  }
  if (nearest.count > 0) s = nearest;
  return v;
}

Eigen::Vector3d nearest_to_origin(Simplex& s) {
  switch (s.count) {
    case 1:
      return s.at(0);
    case 2:
      return nearest_on_segment(s, 0, 1);
    case 3:
      return nearest_on_triangle(s, 0, 1, 2);
    default:
      return nearest_on_tetrahedron(s);
  }
}

/// B in the frame of A.
struct Difference {
  const ConvexShape& a;
  const ConvexShape& b;
  Eigen::Matrix3d R;
  Eigen::Vector3d p;

  /// The farthest point of A - B in a direction.
  [[nodiscard]] Eigen::Vector3d support(const Eigen::Vector3d& direction) const {
    return a.support(direction) - (p + R * b.support(-(R.transpose() * direction)));
  }
  /// How deep the cores overlap, at least: the least way out along the axes of both.
  [[nodiscard]] double overlap() const {
    double least = std::numeric_limits<double>::infinity();
    const auto along = [&](const Eigen::Vector3d& n) {
      least = std::min({least, support(n).dot(n), -support(-n).dot(n)});
    };
    for (int i = 0; i < 3; ++i) {
      along(Eigen::Vector3d::Unit(i));
      along(R.col(i));
    }
    if (p.norm() > kTouching_m) along(p.normalized());
    return std::max(least, 0.0);
  }
};

}  // namespace

Eigen::Vector3d ConvexShape::support(const Eigen::Vector3d& direction) const {
  if (core == Core::kBox) {
    return {std::copysign(half.x(), direction.x()), std::copysign(half.y(), direction.y()),
            std::copysign(half.z(), direction.z())};
  }
  const double across = direction.head<2>().norm();
  const double scale = across > 0 ? half.x() / across : 0;
  return {scale * direction.x(), scale * direction.y(), std::copysign(half.z(), direction.z())};
}

Eigen::AlignedBox3d ConvexShape::bounds(const Eigen::Isometry3d& X) const {
  const Eigen::Vector3d extent = X.linear().cwiseAbs() * half + Eigen::Vector3d::Constant(radius_m);
  return {X.translation() - extent, X.translation() + extent};
}

ConvexShape convex_shape(const decltype(LinkShape::shape)& shape) {
  struct Make {
    ConvexShape operator()(const BoxShape& box) const { return convex_box(box.size); }
    ConvexShape operator()(const CapsuleShape& capsule) const {
      return {.half = {0, 0, 0.5 * capsule.length_m}, .radius_m = capsule.radius_m};
    }
    ConvexShape operator()(const CylinderShape& cylinder) const {
      return {.core = ConvexShape::Core::kCylinder,
              .half = {cylinder.radius_m, cylinder.radius_m, 0.5 * cylinder.length_m}};
    }
    ConvexShape operator()(const SphereShape& sphere) const {
      return {.radius_m = sphere.radius_m};
    }
  };
  return std::visit(Make{}, shape);
}

double distance_bound(const ConvexShape& a, const Eigen::Isometry3d& X_WA, const ConvexShape& b,
                      const Eigen::Isometry3d& X_WB, double enough) {
  const Eigen::Matrix3d R_AW = X_WA.linear().transpose();
  const Difference difference{a, b, R_AW * X_WB.linear(),
                              R_AW * (X_WB.translation() - X_WA.translation())};
  const double radii = a.radius_m + b.radius_m;
  Simplex simplex;
  Eigen::Vector3d v = -difference.p;
  double bound = -std::numeric_limits<double>::infinity();
  for (int i = 0; i < kMostIterations; ++i) {
    const double length = v.norm();
    if (length < kTouching_m) break;
    const Eigen::Vector3d w = difference.support(-v);
    // All of A - B lies beyond the plane through w across v.
    bound = std::max(bound, v.dot(w) / length);
    if (bound - radii > enough || length - bound <= kTolerance_m) return bound - radii;
    simplex.points[static_cast<std::size_t>(simplex.count++)] = w;
    v = nearest_to_origin(simplex);
    if (simplex.count == 4) break;  // the origin is inside
  }
  if (bound > 0) return bound - radii;
  return -difference.overlap() - radii;
}

}  // namespace aprsim::robot
