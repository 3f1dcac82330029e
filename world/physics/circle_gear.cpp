#include "world/physics/circle_gear.hpp"

#include <algorithm>
#include <cmath>

#include "world/physics/ring_search.hpp"

namespace aprsim::physics::detail {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

struct Basis {
  Vector3d c, a1, a2;  ///< centre, radius towards the gear's axis, radius a quarter turn on
  [[nodiscard]] Vector3d at(double angle) const {
    return c + std::cos(angle) * a1 + std::sin(angle) * a2;
  }
};

/// Samples start towards the gear's axis, where an edge first meets a side; number 12 is opposite.
Basis anchored(const Circle& circle) {
  Vector3d towards(-circle.c.x(), -circle.c.y(), 0);
  towards -= towards.dot(circle.axis) * circle.axis;
  if (towards.squaredNorm() < 1e-20) {
    towards = Vector3d::UnitX() - circle.axis.x() * circle.axis;
    if (towards.squaredNorm() < 1e-2) towards = Vector3d::UnitY() - circle.axis.y() * circle.axis;
  }
  const Vector3d a1 = circle.r * towards.normalized();
  return {circle.c, a1, circle.axis.cross(a1)};
}

/// Depth behind the side of the piece where the side is the nearest way out, else kNoDepth.
double side_depth(const Piece& piece, double r, double z) {
  if (z < piece.z0 - piece.low_reach || z > piece.z1 + piece.high_reach) return kNoDepth;
  const double depth = (piece.radius(z) - r) * piece.cosine;
  return piece.to_end(z) < std::max(0.0, depth) ? kNoDepth : depth;
}

struct Samples {
  RingDepths r, z;
};

void touch_side(const Piece& piece, const Basis& basis, const Samples& at, const Isometry3d& X_SG,
                Candidates& out) {
  RingDepths depth;
  for (std::size_t i = 0; i < kRingSamples; ++i) depth[i] = side_depth(piece, at.r[i], at.z[i]);
  const auto depth_at = [&](double angle) {
    const Vector3d q = basis.at(angle);
    return side_depth(piece, std::hypot(q.x(), q.y()), q.z());
  };
  ring_maxima(depth, depth_at, [&](double angle) {
    const Vector3d q = basis.at(angle);
    const double r = std::hypot(q.x(), q.y());
    if (r < 1e-12) return;
    const Vector3d outward(q.x() / r * piece.cosine, q.y() / r * piece.cosine,
                           -piece.slope * piece.cosine);
    out.add(X_SG * q, -(X_SG.linear() * outward), side_depth(piece, r, q.z()));
  });
}

/// Where the circle passes over the rim of the end face at height z_end (outward +-z): the ends of
/// the arc that lies under the face, unless leaving sideways is shorter.
void touch_end(const Piece& piece, double z_end, double r_end, double outward, const Basis& basis,
               const Samples& at, const Isometry3d& X_SG, Candidates& out) {
  RingDepths inside;
  double sideways = 0;
  for (std::size_t i = 0; i < kRingSamples; ++i) {
    inside[i] = r_end - at.r[i];
    sideways = std::max(sideways, inside[i]);
  }
  if (sideways <= 0) return;
  const auto inside_at = [&](double angle) {
    const Vector3d q = basis.at(angle);
    return r_end - std::hypot(q.x(), q.y());
  };
  ring_crossings(inside, inside_at, [&](double angle) {
    const Vector3d q = basis.at(angle);
    const double depth = outward * (z_end - q.z());
    if (depth > sideways || depth > piece.to_end(q.z())) return;
    out.add(X_SG * q, -outward * X_SG.linear().col(2), depth);
  });
}

/// Lies the circle just under an exposed end, and farther from the side?
bool rests_on_end(const Piece& piece, const Samples& at) {
  const double low = *std::max_element(at.z.begin(), at.z.end()) - piece.z_out_low;
  const double high = piece.z_out_high - *std::min_element(at.z.begin(), at.z.end());
  double sideways = 0;
  for (std::size_t i = 0; i < kRingSamples; ++i) {
    sideways = std::max(sideways, piece.radius(at.z[i]) - at.r[i]);
  }
  const double overlap = std::min(low, high);
  return overlap < kResting && overlap < sideways;
}

/// The circle's bounds in the gear's frame.
struct Bounds {
  double z_min, z_max, r_min, r_max;

  explicit Bounds(const Circle& circle) {
    const double sine = std::sqrt(std::max(0.0, 1 - circle.axis.z() * circle.axis.z()));
    const double m = std::hypot(circle.c.x(), circle.c.y());
    z_min = circle.c.z() - circle.r * sine;
    z_max = circle.c.z() + circle.r * sine;
    r_min = std::max({0.0, circle.r * std::abs(circle.axis.z()) - m, m - circle.r});
    r_max = m + circle.r;
  }
};

/// Can any point of the circle touch the side or an end's rim?
bool may_touch(const Piece& piece, const Bounds& circle) {
  const double z0 = piece.z0 - piece.low_reach, z1 = piece.z1 + piece.high_reach;
  if (circle.z_max < z0 || circle.z_min > z1) return false;
  const double at_lo = piece.radius(std::max(circle.z_min, z0));
  const double at_hi = piece.radius(std::min(circle.z_max, z1));
  return circle.r_min < std::max(at_lo, at_hi) && circle.r_max > std::min(at_lo, at_hi);
}

}  // namespace

void circle_on_piece(const Piece& piece, const Isometry3d& X_SG, const Circle& circle,
                     Candidates& out) {
  if (!may_touch(piece, Bounds(circle))) return;
  const Basis basis = anchored(circle);
  const auto& directions = sample_directions();
  Samples at;
  for (std::size_t i = 0; i < kRingSamples; ++i) {
    const Vector3d q = basis.c + directions[i].c * basis.a1 + directions[i].s * basis.a2;
    at.r[i] = std::sqrt(q.x() * q.x() + q.y() * q.y());
    at.z[i] = q.z();
  }
  if (!rests_on_end(piece, at)) touch_side(piece, basis, at, X_SG, out);
  if (piece.low_exposed) touch_end(piece, piece.z0, piece.r0, -1, basis, at, X_SG, out);
  if (piece.high_exposed) touch_end(piece, piece.z1, piece.r1, 1, basis, at, X_SG, out);
}

void circle_on_gear(const GearShape& gear, const Isometry3d& X_SG, const Circle& circle,
                    Candidates& out) {
  for (int k = 0; k < gear.piece_count; ++k) {
    circle_on_piece(gear.pieces[static_cast<std::size_t>(k)], X_SG, circle, out);
  }
}

}  // namespace aprsim::physics::detail
