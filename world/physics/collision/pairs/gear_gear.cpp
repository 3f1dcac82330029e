#include <algorithm>
#include <array>
#include <cmath>

#include "world/physics/collision/pairs/circle_edge_vs_gear.hpp"
#include "world/physics/collision/pairs/narrow_phase.hpp"
#include "world/physics/collision/pairs/rim_vs_pocket.hpp"
#include "world/physics/collision/shapes/length.hpp"
#include "world/physics/collision/speculative/hull_gap.hpp"

// Two unions of frusta about their axes, piece against piece: sides along a line, sides in a point,
// and the rims of each on the sides and end faces of the other.
namespace aprsim::physics {
namespace {

using detail::Candidates;
using detail::GearShape;
using detail::Piece;
using Eigen::Isometry3d;
using Eigen::Vector3d;

/// Axes closer than this (cosine) count as parallel: sides touch along a line, not in a point.
constexpr double kParallel = 0.98;
/// Allowance of bounds for rounding [m].
constexpr double kRounding = 1e-9;

/// The two gears in B's frame. Candidates have their normals into B; those of A are flipped.
struct Gears {
  const GearShape& a;
  const GearShape& b;
  const Isometry3d& X_BA;
};

/// Bounds of a piece of A in B's frame: its extent along B's axis, and of the sphere about it the
/// middle's distance from that axis and the radius.
struct Bounds {
  double lo = 0, hi = 0, off = 0, r = 0;
  [[nodiscard]] bool overlap(const Piece& b) const {
    return hi > b.z0 && lo < b.z1 && off < r + std::max(b.r0, b.r1);
  }
};

using GearBounds = std::array<Bounds, 4>;
GearBounds bounds_in_b(const GearShape& a, const Isometry3d& X_BA) {
  GearBounds bounds;
  // A rim of radius r on an axis of slope cos(a) spans r sin(a) to either side along the other
  // axis.
  const Vector3d u = X_BA.linear().col(2);
  const double sine = std::sqrt(std::max(0.0, 1 - u.z() * u.z())), c = X_BA.translation().z();
  for (std::size_t i = 0; i < static_cast<std::size_t>(a.piece_count); ++i) {
    const Piece& piece = a.pieces[i];
    const double at0 = c + piece.z0 * u.z(), at1 = c + piece.z1 * u.z();
    const Vector3d middle = X_BA * Vector3d(0, 0, 0.5 * (piece.z0 + piece.z1));
    bounds[i] = {.lo = std::min(at0 - piece.r0 * sine, at1 - piece.r1 * sine),
                 .hi = std::max(at0 + piece.r0 * sine, at1 + piece.r1 * sine),
                 .off = length(middle.x(), middle.y()),
                 .r = length(std::max(piece.r0, piece.r1), 0.5 * (piece.z1 - piece.z0))};
  }
  return bounds;
}

/// Two cylinders standing side by side: the ends of the line along which they touch. An end is a
/// rim of one of them on the side of the other, which has the normal. False when they do not stand
/// so: the general search follows.
bool side_by_side(const Piece& a, const Piece& b, const Isometry3d& X_BA, Candidates& out) {
  const Vector3d u = X_BA.linear().col(2), c = X_BA.translation();
  // Parallel cylinders touch along a line. Its two ends hold them; one point would let them rock.
  if (a.slope != 0 || b.slope != 0 || std::abs(u.z()) < kParallel) return false;
  const Vector3d centre = c + 0.5 * (a.z0 + a.z1) * u;
  const double off = length(centre.x(), centre.y());
  if (off < 1e-9) return false;
  // From A's axis across to its side towards B: `rise` along B's axis, `reach_a` across that.
  const double leaning = (centre.x() * u.x() + centre.y() * u.y()) / off;
  const double rise = a.r0 * leaning * u.z() / std::sqrt(1 - leaning * leaning);
  const double reach_a = std::sqrt(std::max(0.0, a.r0 * a.r0 - rise * rise));
  // Heights of A's ends along B's axis, on that side of A.
  const double h0 = c.z() + a.z0 * u.z() + rise, h1 = c.z() + a.z1 * u.z() + rise;
  const double lo = std::max(b.z0, std::min(h0, h1)), hi = std::min(b.z1, std::max(h0, h1));
  if (hi <= lo) return false;
  const auto axis_of_a = [&](double z) { return Vector3d(c + (z - rise - c.z()) / u.z() * u); };
  const Vector3d middle = axis_of_a(0.5 * (lo + hi));
  // Where another exit is shorter, the general search finds it.
  const double overlap = reach_a + b.r0 - length(middle.x(), middle.y());
  if (overlap >= std::min({hi - lo, a.r0, b.r0})) return false;
  for (const double z : {lo, hi}) {
    const Vector3d q = axis_of_a(z);
    const double distance = length(q.x(), q.y());
    if (distance < 1e-9) continue;
    const Vector3d across(-q.x() / distance, -q.y() / distance, 0);
    const double depth = reach_a + b.r0 - distance;
    const Vector3d p = -(b.r0 - 0.5 * depth) * across + Vector3d(0, 0, z);
    if (z == b.z0 || z == b.z1) {
      const Vector3d n = (across - across.dot(u) * u).normalized();
      out.add(p, n, depth * across.dot(n));
    } else {
      out.add(p, across, depth);
    }
  }
  return true;
}

/// Two cylinders crossing: the point between their axes, when it lies within both.
void crossing_sides(const Piece& a, const Piece& b, const Isometry3d& X_BA, Candidates& out) {
  const Vector3d u = X_BA.linear().col(2), c = X_BA.translation();
  if (a.slope != 0 || b.slope != 0 || std::abs(u.z()) > kParallel) return;
  // The point of A's axis that is nearest to B's.
  // Closest points of two lines (Ericson 2005, ch. 5.1.8), with B's axis as z.
  const double s = (c.z() * u.z() - c.dot(u)) / (1 - u.z() * u.z());
  const Vector3d on_a = c + s * u;
  if (s < a.z0 || s > a.z1 || on_a.z() < b.z0 || on_a.z() > b.z1) return;
  const double distance = length(on_a.x(), on_a.y());
  const double depth = a.r0 + b.r0 - distance;
  if (distance < 1e-9 || depth <= 0 || depth > std::min(a.r0, b.r0)) return;
  const Vector3d n(-on_a.x() / distance, -on_a.y() / distance, 0);
  out.add(-(b.r0 - 0.5 * depth) * n + Vector3d(0, 0, on_a.z()), n, depth);
}

/// How far under an end face of a piece a point may be that leaves through it: half of what lies
/// between there and the far side, that of other pieces where the piece is glued to them.
double most_under_end(const GearShape& gear, const Piece& piece) {
  return 0.5 * (std::min(piece.z_out_high, gear.z_high) - std::max(piece.z_out_low, gear.z_low));
}

/// An end face of a piece of B: its height and radius, and the direction of its normal along z.
struct EndFace {
  double z = 0, r = 0, outward = 1;

  [[nodiscard]] double depth(const Vector3d& p) const { return outward * (z - p.z()); }
};

/// How far a rim's disc must move across B's axis, outwards along `d`, until nothing of it is under
/// the end face: the separating distance of two convex shapes in that direction. The part of the
/// disc under the face is a segment of it, {c + s low + w side: s >= t}.
double exit_across(const detail::RimS& rim, const EndFace& end, const Vector3d& d) {
  const double depth = end.depth(rim.c), leg = rim.r * rim.sine;
  const double t = leg <= std::abs(depth) ? -rim.r : -depth / rim.sine;
  const Vector3d in_disc = d - d.dot(rim.u) * rim.u;
  const double along = in_disc.norm();
  double inner = -rim.r * along;  // of the whole disc, along d from its centre
  if (t > -rim.r && along > 0) {
    const Vector3d low = (end.outward * rim.u.z() * rim.u - Vector3d(0, 0, end.outward)) / rim.sine;
    const double g_low = in_disc.dot(low);
    const double g_side = std::sqrt(std::max(0.0, along * along - g_low * g_low));
    // The innermost point of the segment is on its chord, unless that of the disc is in the
    // segment.
    if (-rim.r * g_low / along < t) {
      inner = t * g_low - std::sqrt(std::max(0.0, rim.r * rim.r - t * t)) * g_side;
    }
  }
  return end.r - (rim.c.dot(d) + inner);
}

/// The rim of a piece of A on an exposed end face of a piece of B: four points of the rim, and
/// where two nearly parallel rims cross, none deeper than `most`.
void rim_on_end(const detail::RimS& rim, const EndFace& end, double most, bool crossings,
                Candidates& out) {
  constexpr double kNearlyParallel = 0.1;  // sine; crossings of more inclined rims are edges'
  const Vector3d face(0, 0, end.outward);
  if (end.depth(rim.c) + rim.r * rim.sine <= 0) return;
  const double off = length(rim.c.x(), rim.c.y());
  if (std::max(off - rim.r, rim.r * std::abs(rim.u.z()) - off) > end.r + kRounding) return;
  const auto add = [&](const Vector3d& p) {
    const double depth = end.depth(p), from_axis = length(p.x(), p.y());
    const double exit = from_axis > kRounding
                            ? exit_across(rim, end, Vector3d(p.x(), p.y(), 0) / from_axis)
                            : end.r;
    if (depth < exit && depth < most) out.add(p, -face, depth);
  };
  Vector3d d1, d2;
  detail::anchor_directions(rim, face, rim.sine, d1, d2);
  for (const Vector3d& d : {d1, d2, Vector3d(-d1), Vector3d(-d2)}) {
    const Vector3d p = rim.c + rim.r * d;
    if (length(p.x(), p.y()) <= end.r + kRounding) add(p);
  }
  if (!crossings || rim.sine > kNearlyParallel || off == 0) return;
  // Crossing of two circles whose centres are `off` apart, from B's axis.
  const double to_chord = 0.5 * (off + (end.r - rim.r) * (end.r + rim.r) / off);
  if (std::abs(to_chord) >= end.r) return;
  const double half_chord = std::sqrt(end.r * end.r - to_chord * to_chord);
  const Vector3d to_centre(rim.c.x() / off, rim.c.y() / off, 0);
  for (const double side : {-half_chord, half_chord}) {
    const Vector3d across(-side * to_centre.y(), side * to_centre.x(), 0);
    Vector3d lever = to_chord * to_centre + across - Vector3d(rim.c.x(), rim.c.y(), 0);
    lever -= lever.dot(rim.u) * rim.u;
    add(rim.c + rim.r * lever.normalized());
  }
}

/// The rims of piece `index` of A on piece `on` of B. Candidates in B, normals into B.
void rims_on_piece(const GearShape& a, int index, const GearShape& gear_b, int on,
                   const Isometry3d& X_BA, bool crossings, Candidates& out) {
  const Piece& b = gear_b.pieces[static_cast<std::size_t>(on)];
  const double most = most_under_end(gear_b, b);
  // Each rim is tested as a circle against the side, and as four points against the end faces.
  static const Isometry3d kIdentity = Isometry3d::Identity();
  const Eigen::Matrix3d& R = X_BA.linear();
  const Vector3d e1 = R.col(0), e2 = R.col(1), u = R.col(2);
  const double sine = std::sqrt(std::max(0.0, 1 - u.z() * u.z()));
  for (int k = 0; k < a.ring_count; ++k) {
    const detail::Ring& ring = a.rings[static_cast<std::size_t>(k)];
    if (ring.piece != index) continue;
    const detail::RimS rim{X_BA.translation() + ring.z * u, ring.r, u, e1, e2, sine};
    detail::circle_on_piece(b, kIdentity, {rim.c, u, ring.r}, out);
    if (b.low_exposed) rim_on_end(rim, {b.z0, b.r0, -1}, most, crossings, out);
    if (b.high_exposed) rim_on_end(rim, {b.z1, b.r1, 1}, most, crossings, out);
  }
}

void add_flipped(const Candidates& in, const Isometry3d& X_BA, Candidates& out) {
  for (int i = 0; i < in.size(); ++i) {
    out.add(X_BA * in[i].p, -(X_BA.linear() * in[i].n), in[i].depth);
  }
}

void piece_on_piece(const Gears& g, int i, int j, const Isometry3d& X_AB, Candidates& out) {
  const Piece& a = g.a.pieces[static_cast<std::size_t>(i)];
  const Piece& b = g.b.pieces[static_cast<std::size_t>(j)];
  if (side_by_side(a, b, g.X_BA, out)) return;
  crossing_sides(a, b, g.X_BA, out);
  rims_on_piece(g.a, i, g.b, j, g.X_BA, true, out);
  Candidates on_a;
  rims_on_piece(g.b, j, g.a, i, X_AB, false, on_a);  // the crossings are known
  add_flipped(on_a, g.X_BA, out);
}

}  // namespace

void gear_gear(const GearShape& gear_a, const Isometry3d& X_WA, const GearShape& gear_b,
               const Isometry3d& X_WB, BodyIndex a, BodyIndex b, std::vector<Contact>& out) {
  if (gear_gear_gap(gear_a, X_WA, gear_b, X_WB).m > 0) return;
  const Isometry3d X_BA = X_WB.inverse(Eigen::Isometry) * X_WA;
  const Isometry3d X_AB = X_BA.inverse(Eigen::Isometry);
  const Gears gears{gear_a, gear_b, X_BA};
  Candidates points;
  const GearBounds a_in_b = bounds_in_b(gear_a, X_BA), b_in_a = bounds_in_b(gear_b, X_AB);
  for (std::size_t i = 0; i < static_cast<std::size_t>(gear_a.piece_count); ++i) {
    for (std::size_t j = 0; j < static_cast<std::size_t>(gear_b.piece_count); ++j) {
      // Either piece's cylinder can exclude the pair; the second test uses the other axis.
      if (!a_in_b[i].overlap(gear_b.pieces[j]) || !b_in_a[j].overlap(gear_a.pieces[i])) continue;
      piece_on_piece(gears, static_cast<int>(i), static_cast<int>(j), X_AB, points);
    }
  }
  detail::emit_reduced_by_axis(points, Vector3d::UnitZ(),
                               {X_WB, a, b, SurfacePair::kGearGear, out, true});
}

}  // namespace aprsim::physics
