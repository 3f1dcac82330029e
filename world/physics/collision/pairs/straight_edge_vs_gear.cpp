#include "world/physics/collision/pairs/straight_edge_vs_gear.hpp"

#include <algorithm>
#include <cmath>

#include "world/physics/collision/pairs/frustum_contact.hpp"
#include "world/physics/collision/shapes/length.hpp"

// The edge is a line p + t d in the gear's frame. Its distance to the axis is convex in t, the
// depth under a cone concave, so that the deepest point of a piece is unique and a one-dimensional
// search finds it (golden section: Press et al. 2007, sec. 10.2). Clipping to height and radius:
// Ericson 2005, ch. 5.3.7 (segment against cylinder).
namespace aprsim::physics::detail {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

struct Range {
  double lo, hi;
  [[nodiscard]] bool empty() const { return !(lo < hi); }
};

/// The edge in the gear's frame, p + t d for t in 0 .. length, d of unit length.
struct Edge {
  Vector3d p, d;
  double length;
  double d2;       ///< squared length of d across the gear's axis
  double closest;  ///< t of the point of the infinite line nearest to the axis (0 if parallel)

  [[nodiscard]] Vector3d at(double t) const { return p + t * d; }
  [[nodiscard]] double r(double t) const {
    return physics::length(p.x() + t * d.x(), p.y() + t * d.y());
  }
  [[nodiscard]] double z(double t) const { return p.z() + t * d.z(); }
};

/// Part of the edge within z0 .. z1.
Range within_height(const Edge& e, double z0, double z1) {
  // A level edge is wholly inside the slab or outside.
  if (std::abs(e.d.z()) < 1e-12) {
    return e.p.z() >= z0 && e.p.z() <= z1 ? Range{0, e.length} : Range{0, 0};
  }
  double t0 = (z0 - e.p.z()) / e.d.z(), t1 = (z1 - e.p.z()) / e.d.z();
  if (t0 > t1) std::swap(t0, t1);
  return {std::max(0.0, t0), std::min(e.length, t1)};
}

/// Part of the edge nearer than r to the axis.
Range within_radius(const Edge& e, double r) {
  const double closest = e.r(e.closest);
  if (closest >= r) return {0, 0};
  if (e.d2 < 1e-12) return {0, e.length};
  // Pythagoras across the axis: half the chord of the projected line.
  const double half = std::sqrt((r * r - closest * closest) / e.d2);
  return {std::max(0.0, e.closest - half), std::min(e.length, e.closest + half)};
}

double behind_side(const Piece& piece, const Edge& e, double t) {
  return (piece.radius(e.z(t)) - e.r(t)) * piece.cosine;
}

/// Depth at t: behind the side, or behind the nearer end face. Concave along the edge.
double shortest(const Piece& piece, const Edge& e, double t) {
  return std::min(behind_side(piece, e, t), piece.to_end(e.z(t)));
}

/// Whether the whole range is outside the piece. Planes tangent to its side at a few points each
/// exclude a part of the edge.
bool keeps_out(const Piece& piece, const Edge& e, Range range) {
  constexpr double kSlack = 1e-9;  // for rounding [m]
  constexpr int kMost = 4;
  const Range open = within_height(e, piece.z_out_low - kSlack, piece.z_out_high + kSlack);
  range = {std::max(range.lo, open.lo), std::min(range.hi, open.hi)};
  double t = std::clamp(e.closest, range.lo, std::max(range.lo, range.hi));
  for (int pass = 0; pass < kMost && range.lo <= range.hi; ++pass) {
    const double exit = behind_side(piece, e, t) + kSlack;
    if (exit >= 0) return false;
    // The depth is concave along the edge, so that its tangent at t bounds it. Where the tangent is
    // negative nothing can be inside: Newton's method without a root.
    const Vector3d q = e.at(t);
    const double outward = (q.x() * e.d.x() + q.y() * e.d.y()) / e.r(t);
    const double slope = (piece.slope * e.d.z() - outward) * piece.cosine;
    if (slope == 0) return true;
    (slope > 0 ? range.lo : range.hi) = t - exit / slope;
    t = 0.5 * (range.lo + range.hi);
  }
  return range.lo > range.hi;
}

/// The deepest point of the range, by golden section search.
double innermost(const Piece& piece, const Edge& e, Range range) {
  // A derivative-free search: the depth has a kink where side and end face are equally near.
  constexpr double kGolden = 0.6180339887498949;
  // Behind a cylinder's side the depth is largest where the edge is nearest to the axis.
  if (piece.slope == 0) {
    const double nearest = std::clamp(e.closest, range.lo, range.hi);
    if (behind_side(piece, e, nearest) <= piece.to_end(e.z(nearest))) return nearest;
  }
  double m0 = range.hi - kGolden * (range.hi - range.lo);
  double m1 = range.lo + kGolden * (range.hi - range.lo);
  double f0 = shortest(piece, e, m0), f1 = shortest(piece, e, m1);
  while (range.hi - range.lo > 1e-8) {
    if (f0 < f1) {
      range.lo = m0;
      m0 = m1;
      f0 = f1;
      m1 = range.lo + kGolden * (range.hi - range.lo);
      f1 = shortest(piece, e, m1);
    } else {
      range.hi = m1;
      m1 = m0;
      f1 = f0;
      m0 = range.hi - kGolden * (range.hi - range.lo);
      f0 = shortest(piece, e, m0);
    }
  }
  return 0.5 * (range.lo + range.hi);
}

/// Where the edge passes over the rim of the end face at height z_end (outward +-z), or ends under
/// the face.
void touch_end(double z_end, double r_end, double outward, double longest, const Edge& e,
               const Isometry3d& X_SG, Candidates& out) {
  const Range range = within_radius(e, r_end);
  if (range.empty()) return;
  for (const double t : {range.lo, range.hi}) {
    const Vector3d q = e.at(t);
    const double depth = outward * (z_end - q.z());
    if (depth <= kEndShare * longest) out.add(X_SG * q, -outward * X_SG.linear().col(2), depth);
  }
}

void edge_on_piece(const Piece& piece, const Edge& e, const Isometry3d& X_SG, Candidates& out) {
  // Deepest point first, then both ends of what lies along the side, then what lies under the ends.
  const Range range = within_height(e, piece.z0 - piece.low_reach, piece.z1 + piece.high_reach);
  if (range.empty() || keeps_out(piece, e, range)) return;
  const double inner = innermost(piece, e, range);
  const double longest = shortest(piece, e, inner);
  if (longest <= 0) return;
  add_edge_point(piece, e.at(inner), e.d, X_SG, out);
  // An edge along the side touches it over its whole length.
  for (const double t : {range.lo, range.hi}) {
    const double depth = behind_side(piece, e, t);
    if (depth > kEndShare * longest || depth > piece.to_end(e.z(inner))) continue;
    add_side_point(piece, e.at(t), X_SG, out);
  }
  if (piece.low_exposed) touch_end(piece.z0, piece.r0, -1, longest, e, X_SG, out);
  if (piece.high_exposed) touch_end(piece.z1, piece.r1, 1, longest, e, X_SG, out);
}

/// Does n point out between the faces that meet at p on the edge, or nearly?
bool between_faces(const StraightEdge& edge, const Vector3d& p, const Vector3d& n) {
  constexpr double kAside = 0.02, kAtEnd = 1e-9;
  const Vector3d d = edge.b - edge.a;
  const double t = d.dot(p - edge.a) / d.squaredNorm();
  const bool at_a = t<kAtEnd, at_b = t> 1 - kAtEnd;
  if (!at_a && !at_b) {
    // n's share of each face's normal.
    const double c = edge.m0.dot(edge.m1), n0 = n.dot(edge.m0), n1 = n.dot(edge.m1);
    return n0 - c * n1 > -kAside && n1 - c * n0 > -kAside;
  }
  // At a corner, n's share of each of three faces' normals.
  // Barycentric test on the Gauss map: n = sum of c_i m_i with c_i >= 0, by Cramer's rule.
  const Vector3d& m2 = at_a ? edge.m_a : edge.m_b;
  const double volume = edge.m0.dot(edge.m1.cross(m2));
  if (std::abs(volume) < 1e-6) return true;
  return n.dot(edge.m1.cross(m2)) / volume > -kAside &&
         n.dot(m2.cross(edge.m0)) / volume > -kAside &&
         n.dot(edge.m0.cross(edge.m1)) / volume > -kAside;
}

/// Out through the piece's side, where the edge is nearest to the axis.
void find_beside(const Piece& piece, const Edge& e, const StraightEdge& edge,
                 const Isometry3d& X_SG, std::optional<Candidate>& beside) {
  const Range range = within_height(e, piece.z0, piece.z1);
  if (range.empty()) return;
  Candidates found;
  add_side_point(piece, e.at(std::clamp(e.closest, range.lo, range.hi)), X_SG, found);
  if (found.size() == 0 || !between_faces(edge, found[0].p, found[0].n)) return;
  if (!beside || found[0].depth < beside->depth) beside = found[0];
}

}  // namespace

void edge_on_gear(const GearShape& gear, const Isometry3d& X_SG, const StraightEdge& edge,
                  std::span<PieceContacts> pieces, Candidates& out, Candidates& doubtful) {
  const Eigen::Matrix3d R_GS = X_SG.linear().transpose();
  Edge e;
  e.p = R_GS * (edge.a - X_SG.translation());
  e.d = R_GS * (edge.b - edge.a);
  e.length = e.d.norm();
  if (e.length < 1e-9) return;
  e.d /= e.length;
  const double z_a = e.p.z(), z_b = e.z(e.length);
  if (std::max(z_a, z_b) < gear.z_low || std::min(z_a, z_b) > gear.z_high) return;
  e.d2 = e.d.x() * e.d.x() + e.d.y() * e.d.y();
  e.closest = e.d2 < 1e-12 ? 0 : -(e.p.x() * e.d.x() + e.p.y() * e.d.y()) / e.d2;
  if (e.r(std::clamp(e.closest, 0.0, e.length)) >= gear.r_max) return;
  for (std::size_t k = 0; k < static_cast<std::size_t>(gear.piece_count); ++k) {
    Candidates found;
    edge_on_piece(gear.pieces[k], e, X_SG, found);
    // In doubt: a normal that does not lie between those of the edge's faces.
    for (int i = 0; i < found.size(); ++i) {
      // Normals outside of the edge's normal cone would push the gear into a face that already
      // holds it.
      const bool sure = between_faces(edge, found[i].p, found[i].n);
      pieces[k].held = pieces[k].held || sure;
      (sure ? out : doubtful).add(found[i].p, found[i].n, found[i].depth);
    }
    if (found.size() > 0 && !pieces[k].held) {
      find_beside(gear.pieces[k], e, edge, X_SG, pieces[k].beside);
    }
  }
}

}  // namespace aprsim::physics::detail
