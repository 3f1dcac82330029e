#include "world/physics/collision/circle_edge_vs_gear.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "world/physics/collision/circle_maxima.hpp"
#include "world/physics/collision/frustum_contact.hpp"
#include "world/physics/collision/length.hpp"
#include "world/physics/collision/vector_clones.hpp"

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

/// Radius from the gear's axis, and depth, of each sample: as way_out() has it.
struct Sampled {
  RingValues r, depth;
};
APRSIM_VECTOR_CLONES void sample(const Piece& piece, const CircleBasis& basis, Sampled& out) {
  const RingValues x = basis.samples(0), y = basis.samples(1), z = basis.samples(2);
  const double low = piece.z0 - piece.low_reach, high = piece.z1 + piece.high_reach;
  for (std::size_t i = 0; i < kRingSamples; ++i) {
    out.r[i] = std::sqrt(x[i] * x[i] + y[i] * y[i]);
    double depth = (piece.radius(z[i]) - out.r[i]) * piece.cosine;
    depth = std::min(depth, piece.to_end(z[i]));
    const double beyond = std::min(z[i] - low, high - z[i]);
    out.depth[i] = beyond < 0 ? std::min(depth, beyond) : depth;
  }
}

/// The deepest points; returns the longest way out.
double touch_deepest(const Piece& piece, const CircleBasis& basis, double circle_r,
                     const RingValues& depths, const Isometry3d& X_SG, Candidates& out) {
  double longest = 0;
  const auto way_at = [&](const CirclePoint& at) { return way_out_along(piece, at); };
  ring_maxima(depths, basis, circle_r, way_at, [&](const RingMaximum& found) {
    longest = std::max(longest, found.way.depth);
    add_edge_point(piece, found.at.p, found.at.by_step.normalized(), X_SG, out);
  });
  return longest;
}

/// Where the circle passes over the rim of the end face at height z_end (outward +-z): the ends of
/// the arc that lies under the face.
void touch_end(double z_end, double r_end, double outward, double longest, const CircleBasis& basis,
               const RingValues& radii, const Isometry3d& X_SG, Candidates& out) {
  RingValues inside;
  for (std::size_t i = 0; i < kRingSamples; ++i) inside[i] = r_end - radii[i];
  const auto inside_at = [&](const CirclePoint& at) {
    const double x = at.p.x(), y = at.p.y(), r = length(x, y);
    return std::pair(r_end - r, -(x * at.by_step.x() + y * at.by_step.y()) / r);
  };
  ring_crossings(inside, basis, inside_at, [&](const Vector3d& q) {
    const double depth = outward * (z_end - q.z());
    if (depth <= kEndShare * longest) out.add(X_SG * q, -outward * X_SG.linear().col(2), depth);
  });
}

/// The circle's bounds in the gear's frame.
struct CircleBounds {
  double z_min, z_max, r_min, r_max;

  explicit CircleBounds(const Circle& circle) {
    const double sine = std::sqrt(std::max(0.0, 1 - circle.axis.z() * circle.axis.z()));
    const double m = length(circle.c.x(), circle.c.y());
    z_min = circle.c.z() - circle.r * sine;
    z_max = circle.c.z() + circle.r * sine;
    r_min = std::max({0.0, circle.r * std::abs(circle.axis.z()) - m, m - circle.r});
    r_max = m + circle.r;
  }
};

/// Can any point of the circle touch the side or an end's rim?
bool may_touch(const Piece& piece, const CircleBounds& circle) {
  const double z0 = piece.z0 - piece.low_reach, z1 = piece.z1 + piece.high_reach;
  if (circle.z_max < z0 || circle.z_min > z1) return false;
  // Between the least and the greatest radius of the side at the circle's heights.
  const double at_lo = piece.radius(std::max(circle.z_min, z0));
  const double at_hi = piece.radius(std::min(circle.z_max, z1));
  return circle.r_min < std::max(at_lo, at_hi) && circle.r_max > std::min(at_lo, at_hi);
}

}  // namespace

void circle_on_piece(const Piece& piece, const Isometry3d& X_SG, const Circle& circle,
                     Candidates& out) {
  if (!may_touch(piece, CircleBounds(circle))) return;
  // Sampled around the circle; the local maxima of depth are refined.
  const CircleBasis basis = anchored(circle);
  Sampled at;
  sample(piece, basis, at);
  const double longest = touch_deepest(piece, basis, circle.r, at.depth, X_SG, out);
  if (longest <= 0) return;
  // Ends of the arc that lies under an exposed end face.
  if (piece.low_exposed) touch_end(piece.z0, piece.r0, -1, longest, basis, at.r, X_SG, out);
  if (piece.high_exposed) touch_end(piece.z1, piece.r1, 1, longest, basis, at.r, X_SG, out);
}

void circle_on_gear(const GearShape& gear, const Isometry3d& X_SG, const Circle& circle,
                    Candidates& out) {
  for (int k = 0; k < gear.piece_count; ++k) {
    circle_on_piece(gear.pieces[static_cast<std::size_t>(k)], X_SG, circle, out);
  }
}

}  // namespace aprsim::physics::detail
