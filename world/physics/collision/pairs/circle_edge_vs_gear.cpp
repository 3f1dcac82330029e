#include "world/physics/collision/pairs/circle_edge_vs_gear.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "world/base/simd/vector_clones.hpp"
#include "world/physics/collision/pairs/circle_maxima.hpp"
#include "world/physics/collision/pairs/frustum_contact.hpp"
#include "world/physics/collision/shapes/length.hpp"

namespace aprsim::physics::detail {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// Samples start towards the gear's axis, where an edge first meets a side; number 12 is opposite.
CircleBasis anchored(const Circle& circle) {
  Vector3d towards(-circle.c.x(), -circle.c.y(), 0);
  towards -= towards.dot(circle.axis) * circle.axis;
  if (towards.squaredNorm() < 1e-20) {
    towards = Vector3d::UnitX() - circle.axis.x() * circle.axis;
    if (towards.squaredNorm() < 1e-2) towards = Vector3d::UnitY() - circle.axis.y() * circle.axis;
  }
  const Vector3d a1 = circle.r * towards.normalized();
  return {circle.c, a1, circle.axis.cross(a1)};
}

/// The circle's bounds in the gear's frame.
struct CircleBounds {
  double sine;  ///< of its tilt
  double off;   ///< of its centre from the gear's axis
  double z_min, z_max, r_min, r_max;

  explicit CircleBounds(const Circle& circle)
      : sine(std::sqrt(std::max(0.0, 1 - circle.axis.z() * circle.axis.z()))),
        off(length(circle.c.x(), circle.c.y())) {
    z_min = circle.c.z() - circle.r * sine;
    z_max = circle.c.z() + circle.r * sine;
    r_min = std::max({0.0, circle.r * std::abs(circle.axis.z()) - off, off - circle.r});
    r_max = off + circle.r;
  }
};

/// Radius from the gear's axis and height of each sample, and the candidates for maxima of the
/// depth.
struct Sampled {
  CircleSamples r, z;
  CandidateSamples peaks;
};
APRSIM_VECTOR_CLONES void sample(const Piece& piece, const CircleBasis& basis, double circle_r,
                                 const CircleBounds& bounds, Sampled& out) {
  // Loops over the samples have no branches, so that the compiler vectorises them.
  const CircleSamples x = basis.samples(0), y = basis.samples(1);
  out.z = basis.samples(2);
  const CircleSamples& z = out.z;
  const double low = piece.z0 - piece.low_reach, high = piece.z1 + piece.high_reach;
  ClosedCircleSamples depth, behind, height;
  CircleSamples most;
  for (std::size_t i = 0; i < kCircleSamples; ++i) {
    out.r[i] = std::sqrt(x[i] * x[i] + y[i] * y[i]);
    behind[i] = (piece.radius(z[i]) - out.r[i]) * piece.cosine;
    height[i] = z[i];
    const double least = std::min(behind[i], piece.to_end(z[i]));
    const double beyond = std::min(z[i] - low, high - z[i]);
    depth[i] = beyond < 0 ? std::min(least, beyond) : least;
  }
  for (auto* values : {&depth, &behind, &height}) values->back() = values->front();
  // Bounds between two samples: the height bulges by that of the circle, the depth behind the side
  // by the largest second derivative of radius and height. No depth grows faster than the arc.
  // The bounds let most arcs be skipped without a search. They are safe: a sample's arc is dropped
  // only if no point of it can be inside.
  const double rise = circle_r * bounds.sine;
  const double bend =
      circle_r * circle_r / bounds.r_min - bounds.r_min + bounds.off + std::abs(piece.slope) * rise;
  const double half_arc = 0.5 * kSampleAngle * circle_r;
  const double bulge = std::min(half_arc, kSampleBulge * bend * piece.cosine) + kBoundSlack;
  const double over = kSampleBulge * rise + kBoundSlack;
  const double lowest = std::max(piece.z_out_low, low) - over;
  const double highest = std::min(piece.z_out_high, high) + over;
  for (std::size_t i = 0; i < kCircleSamples; ++i) {
    const double a = behind[i] + bulge, b = behind[i + 1] + bulge;
    const double z_a = height[i], z_b = height[i + 1];
    most[i] = std::min(upper_bound_of_min(a, b, z_a - lowest, z_b - lowest),
                       upper_bound_of_min(a, b, highest - z_a, highest - z_b));
  }
  out.peaks = find_candidate_samples(depth, most, circle_r);
}

/// Adds the deepest points; returns the largest depth.
double touch_deepest(const Piece& piece, const CircleBasis& basis, double circle_r,
                     const Sampled& sampled, const Isometry3d& X_SG, Candidates& out) {
  double longest = 0;
  const auto exit_at = [&](const CirclePoint& at) { return penetration_exit_along(piece, at); };
  circle_extrema(sampled.peaks, basis, circle_r, exit_at, [&](const CircleMaximum& found) {
    longest = std::max(longest, found.exit.depth);
    add_edge_point(piece, found.at.p, found.at.by_step.normalized(), X_SG, out);
  });
  return longest;
}

/// Where the circle passes over the rim of the end face at height z_end (outward +-z): the ends of
/// the arc that lies under the face. `over`: how far the circle bulges in height between samples.
void touch_end(double z_end, double r_end, double outward, double longest, const CircleBasis& basis,
               const Sampled& sampled, double over, const Isometry3d& X_SG, Candidates& out) {
  CircleSamples inside;
  for (std::size_t i = 0; i < kCircleSamples; ++i) inside[i] = r_end - sampled.r[i];
  const auto may_be_under = [&](int i) {
    const double a = outward * (z_end - at_sample(sampled.z, i));
    const double b = outward * (z_end - at_sample(sampled.z, i + 1));
    return std::max(a, b) + over > 0 && std::min(a, b) - over < kEndShare * longest;
  };
  // Roots of r_end - r(angle) bound the arc under the face.
  const auto inside_at = [&](const CirclePoint& at) {
    const double x = at.p.x(), y = at.p.y(), r = length(x, y);
    return std::pair(r_end - r, -(x * at.by_step.x() + y * at.by_step.y()) / r);
  };
  circle_crossings(inside, basis, may_be_under, inside_at, [&](const Vector3d& q) {
    const double depth = outward * (z_end - q.z());
    if (depth <= kEndShare * longest) out.add(X_SG * q, -outward * X_SG.linear().col(2), depth);
  });
}

/// Does the plane that touches the piece's side towards the circle's centre keep all points of the
/// circle outside that are between the heights of the piece?
bool kept_aside(const Piece& piece, const Circle& circle, const CircleBounds& bounds) {
  constexpr double kLevel = 1e-3;  // sine of the tilt below which the radius bound decides
  if (bounds.off < circle.r || bounds.sine < kLevel) return false;
  // Separating plane: tangent to the cone in the meridian plane through the circle's centre. The
  // support of the circle against it is known in closed form.
  const Vector3d &c = circle.c, &n = circle.axis;
  // How fast the exit through the plane grows up the circle and level along it.
  const double towards = (c.x() * n.x() + c.y() * n.y()) / bounds.off;
  const double beside = (c.y() * n.x() - c.x() * n.y()) / bounds.off;
  const double up = (piece.slope * bounds.sine + n.z() * towards / bounds.sine) * piece.cosine;
  const double level = beside / bounds.sine * piece.cosine;
  // The longest is in the direction, by the sine of its elevation, in which it grows fastest, or
  // next to that between the heights.
  const double fastest = length(up, level), rise = circle.r * bounds.sine;
  const double lowest = (piece.z0 - piece.low_reach - kBoundSlack - c.z()) / rise;
  const double highest = (piece.z1 + piece.high_reach + kBoundSlack - c.z()) / rise;
  const double wanted = fastest > 0 ? up / fastest : 0;
  const double sine = std::clamp(std::min(std::max(wanted, lowest), highest), -1.0, 1.0);
  const double at_centre = (piece.radius(c.z()) - bounds.off) * piece.cosine;
  const double grown = std::abs(level) * std::sqrt(1 - sine * sine) + up * sine;
  return at_centre + circle.r * grown < -kBoundSlack;
}

/// Can any point of the circle touch the side or an end's rim?
bool may_touch(const Piece& piece, const CircleBounds& circle) {
  // Interval tests in height and radius, the two coordinates of a solid of revolution.
  const double z0 = piece.z0 - piece.low_reach, z1 = piece.z1 + piece.high_reach;
  if (circle.z_max < z0 || circle.z_min > z1) return false;
  // Between the least and the greatest radius of the side at the circle's heights.
  const double at_lo = piece.radius(std::max(circle.z_min, z0));
  const double at_hi = piece.radius(std::min(circle.z_max, z1));
  return circle.r_min < std::max(at_lo, at_hi) && circle.r_max > std::min(at_lo, at_hi);
}

void circle_on_piece(const Piece& piece, const Isometry3d& X_SG, const Circle& circle,
                     const CircleBounds& bounds, Candidates& out) {
  if (!may_touch(piece, bounds) || kept_aside(piece, circle, bounds)) return;
  // Sampled around the circle; the local maxima of depth are refined.
  const CircleBasis basis = anchored(circle);
  Sampled at;
  sample(piece, basis, circle.r, bounds, at);
  const double longest = touch_deepest(piece, basis, circle.r, at, X_SG, out);
  if (longest <= 0) return;
  // Ends of the arc that lies under an exposed end face.
  const double over = kSampleBulge * circle.r * bounds.sine + kBoundSlack;
  if (piece.low_exposed) touch_end(piece.z0, piece.r0, -1, longest, basis, at, over, X_SG, out);
  if (piece.high_exposed) touch_end(piece.z1, piece.r1, 1, longest, basis, at, over, X_SG, out);
}

}  // namespace

void circle_on_piece(const Piece& piece, const Isometry3d& X_SG, const Circle& circle,
                     Candidates& out) {
  circle_on_piece(piece, X_SG, circle, CircleBounds(circle), out);
}

void circle_on_gear(const GearShape& gear, const Isometry3d& X_SG, const Circle& circle,
                    Candidates& out) {
  const CircleBounds bounds(circle);
  for (int k = 0; k < gear.piece_count; ++k) {
    circle_on_piece(gear.pieces[static_cast<std::size_t>(k)], X_SG, circle, bounds, out);
  }
}

}  // namespace aprsim::physics::detail
