#include "world/physics/collision/shapes/nearness.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "world/physics/collision/shapes/length.hpp"

namespace aprsim::physics::detail {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// In the plane of the polygon.
double polygon_distance(const Prism& prism, const Vector2d& p, Vector2d& out) {
  double inside = -1e30, outside2 = 1e30;
  for (int i = 0; i < prism.sides; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double beyond = prism.n[k].dot(p) - prism.off[k];
    if (beyond > inside) {
      inside = beyond;
      if (outside2 == 1e30) out = prism.n[k];
    }
    if (beyond <= 0) continue;
    // Nearest point of the side (Ericson 2005, ch. 5.1.2).
    const Vector2d side = prism.corner(i + 1) - prism.corner(i);
    const double t = std::clamp((p - prism.corner(i)).dot(side) / side.squaredNorm(), 0.0, 1.0);
    const Vector2d away = p - prism.corner(i) - t * side;
    if (away.squaredNorm() >= outside2) continue;
    outside2 = away.squaredNorm();
    out = away;
  }
  if (outside2 == 1e30) return inside;
  const double distance = std::sqrt(outside2);
  if (distance > 0) out /= distance;
  return distance;
}

/// Nearest point of the segment from a to b.
Vector3d on_segment(const Vector3d& a, const Vector3d& b, const Vector3d& p) {
  const Vector3d side = b - a;
  return a + std::clamp((p - a).dot(side) / side.squaredNorm(), 0.0, 1.0) * side;
}

}  // namespace

Nearness nearness(const Prism& prism, const Vector3d& p) {
  Vector2d beside;
  const double side = polygon_distance(prism, p.head<2>(), beside);
  const bool over = p.z() - prism.z1 >= prism.z0 - p.z();
  const double end = over ? p.z() - prism.z1 : prism.z0 - p.z();
  const Vector3d up(0, 0, over ? 1 : -1), across(beside.x(), beside.y(), 0);
  if (side <= 0 || end <= 0) return side > end ? Nearness{side, across} : Nearness{end, up};
  const double distance = length(side, end);
  return {distance, (side * across + end * up) / distance};
}

Nearness nearness(const Vector3d& size, const Vector3d& p) {
  const Vector3d beyond = p.cwiseAbs() - 0.5 * size;
  const Vector3d outside = beyond.cwiseMax(0);
  const auto sign = [&p](Eigen::Index i) { return std::copysign(1.0, p(i)); };
  const double distance = outside.norm();
  if (distance > 0) {
    const Vector3d away(sign(0) * outside.x(), sign(1) * outside.y(), sign(2) * outside.z());
    return {distance, away / distance};
  }
  Eigen::Index axis = 0;
  const double inside = beyond.maxCoeff(&axis);
  return {inside, sign(axis) * Vector3d::Unit(axis)};
}

Nearness nearness(const Piece& piece, const Vector3d& p) {
  // In the meridian plane a frustum is a trapezium: ends z0 and z1, side from r0 to r1.
  const double r = length(p.x(), p.y()), z = p.z();
  const Vector3d radial = r > 0 ? Vector3d(p.x() / r, p.y() / r, 0) : Vector3d(Vector3d::UnitX());
  const Vector2d q(r, z), normal(piece.cosine, -piece.slope * piece.cosine);
  const auto in_space = [&radial](const Vector2d& n) -> Vector3d {
    return n.x() * radial + n.y() * Vector3d::UnitZ();
  };
  const double low = piece.z0 - z, high = z - piece.z1;
  const double side = (r - piece.radius(z)) * piece.cosine;
  if (low <= 0 && high <= 0 && side <= 0) {
    const double most = std::max({low, high, side});
    if (most == side) return {side, in_space(normal)};
    return {most, Vector3d(0, 0, most == high ? 1 : -1)};
  }
  const auto nearest = [&q](const Vector2d& a, const Vector2d& b) -> Vector2d {
    const Vector2d along = b - a;
    const double length2 = along.squaredNorm();
    const double t = length2 > 0 ? std::clamp((q - a).dot(along) / length2, 0.0, 1.0) : 0;
    return a + t * along;
  };
  const std::array<Vector2d, 3> feet = {nearest({0, piece.z0}, {piece.r0, piece.z0}),
                                        nearest({0, piece.z1}, {piece.r1, piece.z1}),
                                        nearest({piece.r0, piece.z0}, {piece.r1, piece.z1})};
  const Vector2d foot = *std::min_element(
      feet.begin(), feet.end(),
      [&q](const auto& a, const auto& b) { return (q - a).squaredNorm() < (q - b).squaredNorm(); });
  const double distance = (q - foot).norm();
  if (distance > 0) return {distance, in_space((q - foot) / distance)};
  return {0, in_space(normal)};
}

Nearness nearness(const Polytope& polytope, const Vector3d& p) {
  double inside = -1e30, nearest2 = 1e30;
  Vector3d out = Vector3d::UnitZ(), away = Vector3d::Zero();
  for (const Polytope::Face& face : polytope.faces) {
    const double beyond = face.n.dot(p) - face.off;
    if (beyond > inside) {
      inside = beyond;
      out = face.n;
    }
    if (beyond <= 0) continue;
    // A foot within a face that the point is before is the nearest point of all; else it is on an
    // edge.
    bool within = true;
    for (int k = 0; k < face.count; ++k) {
      const Vector3d& a = polytope.corner(polytope.loop_corner(face, k));
      const Vector3d& b = polytope.corner(polytope.loop_corner(face, k + 1));
      if (face.n.dot((b - a).cross(p - a)) >= 0) continue;
      within = false;
      const Vector3d from_edge = p - on_segment(a, b, p);
      if (from_edge.squaredNorm() >= nearest2) continue;
      nearest2 = from_edge.squaredNorm();
      away = from_edge;
    }
    if (within) return {beyond, face.n};
  }
  if (inside <= 0) return {inside, out};
  const double distance = std::sqrt(nearest2);
  return {distance, distance > 0 ? Vector3d(away / distance) : out};
}

Nearness capsule_nearness(double radius_m, double half_length_m, const Vector3d& p) {
  const Vector3d away = p - Vector3d(0, 0, std::clamp(p.z(), -half_length_m, half_length_m));
  const double distance = away.norm();
  return {distance - radius_m,
          distance > 0 ? Vector3d(away / distance) : Vector3d(Vector3d::UnitX())};
}

}  // namespace aprsim::physics::detail
