#include "world/scene/model/pieces.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace aprsim::scene {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Volume, first moment and second moments (integral of x x^T) about a frame's origin.
struct PieceMoments {
  double volume = 0;
  Vector3d first = Vector3d::Zero();
  Matrix3d second = Matrix3d::Zero();

  void add(const PieceMoments& m) {
    volume += m.volume;
    first += m.first;
    second += m.second;
  }
  [[nodiscard]] PieceMoments moved(const Pose& X) const {
    const Matrix3d R = X.q.toRotationMatrix();
    const Vector3d turned = R * first;
    PieceMoments out;
    out.volume = volume;
    out.first = turned + volume * X.p;
    out.second = R * second * R.transpose() + turned * X.p.transpose() + X.p * turned.transpose() +
                 volume * (X.p * X.p.transpose());
    return out;
  }
};

/// Frustum about z between two heights. Three-point Gauss quadrature is exact: every integrand is a
/// polynomial in z of degree 4 or less (Abramowitz & Stegun 1964, table 25.4).
PieceMoments frustum_moments(double z0, double r0, double z1, double r1) {
  const std::array<double, 3> node{-std::sqrt(0.6), 0, std::sqrt(0.6)};
  const std::array<double, 3> weight{5.0 / 9, 8.0 / 9, 5.0 / 9};
  PieceMoments m;
  for (std::size_t i = 0; i < 3; ++i) {
    const double t = 0.5 * (1 + node[i]);
    const double z = z0 + (z1 - z0) * t, r = r0 + (r1 - r0) * t;
    const double dv = 0.5 * weight[i] * (z1 - z0) * std::numbers::pi * r * r;
    m.volume += dv;
    m.first.z() += dv * z;
    m.second(2, 2) += dv * z * z;
    // Second moment of a disc about its diameter: r^2 / 4 per volume.
    m.second(0, 0) += dv * r * r / 4;
    m.second(1, 1) += dv * r * r / 4;
  }
  return m;
}

/// Tetrahedron of the origin and three points: the integral of x x^T is V / 20 times the sum of the
/// corners' squares and the square of their sum (Dobrovolskis 1996).
PieceMoments tetrahedron(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  PieceMoments m;
  m.volume = a.dot(b.cross(c)) / 6;
  const Vector3d sum = a + b + c;
  m.first = m.volume / 4 * sum;
  m.second = m.volume / 20 *
             (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  return m;
}

/// Moments of a piece in its own frame.
struct MomentsOf {
  PieceMoments operator()(const api::BoxPiece& box) const {
    PieceMoments m;
    m.volume = box.size.prod();
    m.second.diagonal() = m.volume / 12 * box.size.cwiseAbs2();
    return m;
  }
  PieceMoments operator()(const api::ConePiece& cone) const {
    const double half = 0.5 * cone.height_m;
    return frustum_moments(-half, cone.bottom_radius_m, half, cone.top_radius_m);
  }
  PieceMoments operator()(const api::CapsulePiece& capsule) const {
    const double r = capsule.radius_m, half = 0.5 * capsule.length_m, pi = std::numbers::pi;
    PieceMoments m = frustum_moments(-half, r, half, r);
    // Two half balls: their centroids lie 3 r / 8 beyond the segment's ends.
    const double ball = 4 * pi / 3 * r * r * r, beyond = 0.375 * r;
    m.volume += ball;
    m.second.diagonal().array() += ball * r * r / 5;
    m.second(2, 2) += ball * (half * half + 2 * half * beyond);
    return m;
  }
  PieceMoments operator()(const api::PrismPiece& prism) const {
    PieceMoments m;
    const double h = prism.height_m;
    // Green's theorem over the sides.
    for (std::size_t i = 0; i < prism.corners.size(); ++i) {
      const Eigen::Vector2d &a = prism.corners[i],
                            &b = prism.corners[(i + 1) % prism.corners.size()];
      const double cross = a.x() * b.y() - a.y() * b.x();
      m.volume += h * cross / 2;
      m.first.head<2>() += h * cross / 6 * (a + b);
      const double xy = a.x() * b.y() + 2 * (a.x() * a.y() + b.x() * b.y()) + b.x() * a.y();
      m.second(0, 0) += h * cross / 12 * (a.x() * a.x() + a.x() * b.x() + b.x() * b.x());
      m.second(1, 1) += h * cross / 12 * (a.y() * a.y() + a.y() * b.y() + b.y() * b.y());
      m.second(0, 1) += h * cross / 24 * xy;
    }
    m.second(1, 0) = m.second(0, 1);
    m.second(2, 2) = m.volume * h * h / 12;
    return m;
  }
  PieceMoments operator()(const api::HullPiece& hull) const {
    PieceMoments m;
    const auto at = [&hull](int i) -> const Vector3d& {
      return hull.corners[static_cast<std::size_t>(i)];
    };
    for (const auto& face : hull.faces) {
      for (std::size_t k = 1; k + 1 < face.size(); ++k) {
        m.add(tetrahedron(at(face[0]), at(face[k]), at(face[k + 1])));
      }
    }
    return m;
  }
};

struct SupportOf {
  const Vector3d& d;
  Vector3d operator()(const api::BoxPiece& box) const {
    return {std::copysign(box.size.x() / 2, d.x()), std::copysign(box.size.y() / 2, d.y()),
            std::copysign(box.size.z() / 2, d.z())};
  }
  Vector3d operator()(const api::ConePiece& cone) const {
    const double lateral = std::hypot(d.x(), d.y()), half = 0.5 * cone.height_m;
    const bool upper =
        cone.top_radius_m * lateral + half * d.z() >= cone.bottom_radius_m * lateral - half * d.z();
    const double scale =
        lateral > 0 ? (upper ? cone.top_radius_m : cone.bottom_radius_m) / lateral : 0;
    return {d.x() * scale, d.y() * scale, upper ? half : -half};
  }
  Vector3d operator()(const api::CapsulePiece& capsule) const {
    const double norm = d.norm();
    const Vector3d end(0, 0, std::copysign(0.5 * capsule.length_m, d.z()));
    return norm > 0 ? Vector3d(end + capsule.radius_m / norm * d) : end;
  }
  Vector3d operator()(const api::PrismPiece& prism) const {
    const Eigen::Vector2d* best = &prism.corners.front();
    for (const Eigen::Vector2d& corner : prism.corners) {
      if (d.head<2>().dot(corner) > d.head<2>().dot(*best)) best = &corner;
    }
    return {best->x(), best->y(), std::copysign(0.5 * prism.height_m, d.z())};
  }
  Vector3d operator()(const api::HullPiece& hull) const {
    const Vector3d* best = &hull.corners.front();
    for (const Vector3d& corner : hull.corners) {
      if (d.dot(corner) > d.dot(*best)) best = &corner;
    }
    return *best;
  }
};

/// A plane through three points with all others behind it, and the points on it in order.
struct HullFaces {
  std::span<const Vector3d> points;
  double tolerance;
  std::vector<Vector3d> normals;
  std::vector<std::vector<int>> faces;

  void try_plane(std::size_t i, std::size_t j, std::size_t k) {
    Vector3d n = (points[j] - points[i]).cross(points[k] - points[i]);
    const double area = n.norm();
    if (area <= tolerance * (points[j] - points[i]).norm()) return;
    n /= area;
    double above = 0, below = 0;
    for (const Vector3d& p : points) {
      above = std::max(above, n.dot(p - points[i]));
      below = std::max(below, -n.dot(p - points[i]));
    }
    if (above > tolerance && below > tolerance) return;
    if (above > tolerance) n = -n;
    for (std::size_t f = 0; f < normals.size(); ++f) {
      const Vector3d& on = points[static_cast<std::size_t>(faces[f].front())];
      const auto lies_on = [&](std::size_t p) {
        return std::abs(normals[f].dot(points[p] - on)) <= tolerance;
      };
      if (lies_on(i) && lies_on(j) && lies_on(k) && normals[f].dot(n) > 0) return;
    }
    add_face(n, i);
  }

  void add_face(const Vector3d& n, std::size_t on) {
    std::vector<int> loop;
    Vector3d middle = Vector3d::Zero();
    for (std::size_t p = 0; p < points.size(); ++p) {
      if (std::abs(n.dot(points[p] - points[on])) > tolerance) continue;
      loop.push_back(static_cast<int>(p));
      middle += points[p];
    }
    middle /= static_cast<double>(loop.size());
    const auto at = [&](int p) -> const Vector3d& { return points[static_cast<std::size_t>(p)]; };
    // Gift wrapping (Jarvis 1973) in the plane, from the corner farthest from the middle.
    std::vector<int> corners;
    int start = loop.front();
    for (const int p : loop) {
      if ((at(p) - middle).squaredNorm() > (at(start) - middle).squaredNorm()) start = p;
    }
    int from = start;
    do {
      corners.push_back(from);
      int next = -1;
      for (const int p : loop) {
        if (p == from) continue;
        if (next < 0) {
          next = p;
          continue;
        }
        const Vector3d a = at(next) - at(from), b = at(p) - at(from);
        const double turn = n.dot(a.cross(b));
        const double straight = tolerance * std::max(a.norm(), b.norm());
        if (turn < -straight || (turn <= straight && b.squaredNorm() > a.squaredNorm())) next = p;
      }
      from = next;
    } while (from != start && corners.size() <= loop.size());
    normals.push_back(n);
    faces.push_back(std::move(corners));
  }
};

}  // namespace

Vector3d support_of(const api::Piece& piece, const Vector3d& d) {
  return std::visit(SupportOf{d}, piece.shape);
}

Eigen::AlignedBox3d own_bounds_of(const api::Piece& piece) {
  Eigen::AlignedBox3d box;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      const Vector3d d = sign * Vector3d::Unit(axis);
      const Vector3d p = support_of(piece, d);
      if (box.isEmpty()) box = Eigen::AlignedBox3d(p, p);
      box.min()(axis) = std::min(box.min()(axis), p(axis));
      box.max()(axis) = std::max(box.max()(axis), p(axis));
    }
  }
  return box;
}

Eigen::AlignedBox3d bounds_of(std::span<const api::Piece> pieces) {
  constexpr double kMost = 1e30;
  Eigen::AlignedBox3d box(Vector3d::Constant(kMost), Vector3d::Constant(-kMost));
  for (const api::Piece& piece : pieces) {
    const Matrix3d R = piece.X_BP.q.toRotationMatrix();
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3d d = R.row(axis).transpose();
      box.min()(axis) =
          std::min(box.min()(axis), piece.X_BP.p(axis) + d.dot(support_of(piece, -d)));
      box.max()(axis) = std::max(box.max()(axis), piece.X_BP.p(axis) + d.dot(support_of(piece, d)));
    }
  }
  return box;
}

UnitMass unit_mass_of(std::span<const api::Piece> pieces) {
  PieceMoments total;
  for (const api::Piece& piece : pieces) {
    total.add(std::visit(MomentsOf{}, piece.shape).moved(piece.X_BP));
  }
  UnitMass out;
  out.volume_m3 = total.volume;
  if (!(total.volume > 0)) return out;
  out.com = total.first / total.volume;
  // Steiner's theorem, and from second moments to inertia: I = tr(S) 1 - S.
  const Matrix3d central = total.second - total.volume * (out.com * out.com.transpose());
  out.inertia = central.trace() * Matrix3d::Identity() - central;
  return out;
}

api::HullPiece hull_of(std::span<const Vector3d> points) {
  constexpr double kRelative = 1e-9;
  Eigen::AlignedBox3d box;
  for (const Vector3d& p : points) box.extend(p);
  HullFaces found{points, kRelative * box.diagonal().norm(), {}, {}};
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = i + 1; j < points.size(); ++j) {
      for (std::size_t k = j + 1; k < points.size(); ++k) found.try_plane(i, j, k);
    }
  }
  api::HullPiece hull;
  if (found.faces.size() < 4) return hull;
  // Only corners stay, in the order of the points.
  std::vector<int> number(points.size(), -1);
  for (const auto& face : found.faces) {
    for (const int p : face) number[static_cast<std::size_t>(p)] = 0;
  }
  for (std::size_t p = 0; p < points.size(); ++p) {
    if (number[p] < 0) continue;
    number[p] = static_cast<int>(hull.corners.size());
    hull.corners.push_back(points[p]);
  }
  for (auto& face : found.faces) {
    for (int& p : face) p = number[static_cast<std::size_t>(p)];
  }
  hull.faces = std::move(found.faces);
  return hull;
}

}  // namespace aprsim::scene
