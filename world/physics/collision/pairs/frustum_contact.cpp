#include "world/physics/collision/pairs/frustum_contact.hpp"

#include <cmath>

#include "world/physics/collision/shapes/length.hpp"

// Contact of a point of an edge with a frustum. A convex body's contact normal at an edge lies
// between the normals of the two faces that meet there (Ericson 2005, ch. 5.1.8 for edges;
// Gregorius, "The Separating Axis Test", GDC 2013, for Gauss maps). Distances are exact: along a
// meridian a frustum is a trapezium.
namespace aprsim::physics::detail {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// Exits through side and end that differ by less than this share are one through the rim.
constexpr double kCorner = 0.05;
/// Edge and rim more parallel than this (sine) touch face to face.
constexpr double kAlongRim = 0.05;

Vector3d side_normal(const Piece& piece, const Vector3d& q, double r) {
  // Outward normal of the cone r = r0 + slope (z - z0): (1, -slope) in the meridian plane, scaled
  // by the cosine.
  return {q.x() / r * piece.cosine, q.y() / r * piece.cosine, -piece.slope * piece.cosine};
}

/// Edge against rim, as two edges of polyhedra: the normal is across both. False when the edge runs
/// along the rim, or one of the faces alone is the exit.
bool add_rim_crossing(const Piece& piece, const Vector3d& q, double r, bool low, const Vector3d& d,
                      const Isometry3d& X_SG, Candidates& out) {
  if (!(low ? piece.low_exposed : piece.high_exposed)) return false;
  const Vector3d tangent(-q.y() / r, q.x() / r, 0);
  Vector3d n = d.cross(tangent);
  const double sine = n.norm();
  if (sine < kAlongRim) return false;
  const Vector3d side = side_normal(piece, q, r), end(0, 0, low ? -1 : 1);
  n *= (n.dot(side + end) < 0 ? -1 : 1) / sine;
  // Gauss map of the rim: a normal beyond the two faces' normals belongs to a face, not to the rim.
  if (n.dot(side) < 0 || n.dot(end) < 0) return false;
  const double rim_r = low ? piece.r0 : piece.r1, rim_z = low ? piece.z0 : piece.z1;
  const Vector3d rim(q.x() / r * rim_r, q.y() / r * rim_r, rim_z);
  out.add(X_SG * q, -(X_SG.linear() * n), n.dot(rim - q));
  return true;
}

}  // namespace

PenetrationExit penetration_exit(const Piece& piece, double r, double z) {
  // The nearest of the side and both ends.
  PenetrationExit exit{(piece.radius(z) - r) * piece.cosine, kThroughSide};
  // The minimum translation to leave a convex body is the least of the distances to its faces.
  const double low = z - piece.z_out_low, high = piece.z_out_high - z;
  if (low < exit.depth) exit = {low, kThroughLow};
  if (high < exit.depth) exit = {high, kThroughHigh};
  // Above or below the piece there is nothing to leave.
  const double beyond = std::min(z - piece.z0 + piece.low_reach, piece.z1 + piece.high_reach - z);
  if (beyond < 0 && beyond < exit.depth) exit = {beyond, kOutside};
  return exit;
}

ExitWithGradient penetration_exit_along(const Piece& piece, const CirclePoint& at) {
  const double x = at.p.x(), y = at.p.y(), z = at.p.z(), z_on = at.by_step.z();
  const double r = length(x, y);
  ExitWithGradient exit{penetration_exit(piece, r, z)};
  switch (exit.kind) {
    case kThroughSide: {
      // d r / d s = (x x' + y y') / r. The product with r, `turn`, has the same sign and is better
      // behaved near the axis, where d r / d s jumps.
      const double r_on = x * at.by_step.x() + y * at.by_step.y();  // times r
      exit.turn = (piece.slope * z_on * r - r_on) * piece.cosine;
      exit.slope = r > 0 ? exit.turn / r : 0;
      return exit;
    }
    case kThroughLow:
      exit.slope = z_on;
      break;
    case kThroughHigh:
      exit.slope = -z_on;
      break;
    default:
      exit.excluded = true;
      exit.slope = z - piece.z0 + piece.low_reach < piece.z1 + piece.high_reach - z ? z_on : -z_on;
  }
  exit.turn = exit.slope;
  return exit;
}

void add_side_point(const Piece& piece, const Vector3d& q, const Isometry3d& X_SG,
                    Candidates& out) {
  const double r = length(q.x(), q.y());
  const double depth = (piece.radius(q.z()) - r) * piece.cosine;
  if (r < 1e-12) return;
  out.add(X_SG * q, -(X_SG.linear() * side_normal(piece, q, r)), depth);
}

void add_edge_point(const Piece& piece, const Vector3d& q, const Vector3d& d,
                    const Isometry3d& X_SG, Candidates& out) {
  const double r = length(q.x(), q.y());
  const double side = (piece.radius(q.z()) - r) * piece.cosine, end = piece.to_end(q.z());
  const double least = std::min(side, end);
  if (least <= 0 || r < 1e-12) return;
  const bool low = q.z() - piece.z_out_low < piece.z_out_high - q.z();
  if (std::abs(side - end) < kCorner * least && add_rim_crossing(piece, q, r, low, d, X_SG, out)) {
    return;
  }
  // One of the faces alone.
  if (side <= end) {
    out.add(X_SG * q, -(X_SG.linear() * side_normal(piece, q, r)), side);
  } else if (low ? piece.opens_low() : piece.opens_high()) {
    out.add(X_SG * q, (low ? 1.0 : -1.0) * X_SG.linear().col(2), end);
  }
}

}  // namespace aprsim::physics::detail
