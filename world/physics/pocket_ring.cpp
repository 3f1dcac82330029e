#include "world/physics/pocket_ring.hpp"

#include <algorithm>
#include <cmath>

#include "world/physics/ring_search.hpp"

namespace aprsim::physics::detail {
namespace {

using Eigen::Vector3d;

/// Tilt (sine) below which the points are body-fixed, and above which they follow the tilt. On a
/// disc of 50 mm the blend spans 5 to 25 um of height.
constexpr double kLevel = 1e-4, kTilted = 5e-4;

struct Basis {
  Vector3d c, a1, a2;
  [[nodiscard]] Vector3d at(double angle) const {
    return c + std::cos(angle) * a1 + std::sin(angle) * a2;
  }
};

/// Samples start in the direction in which the rim is off the pocket's axis.
Basis anchored(const RimS& rim, const PocketProfile& pocket) {
  const Vector3d d(rim.c.x() - pocket.x, rim.c.y() - pocket.y, 0);
  Vector3d along = d - d.dot(rim.u) * rim.u;
  const double norm = along.norm();
  along = norm > 1e-10 ? Vector3d(along / norm) : rim.e1;
  return {rim.c - Vector3d(pocket.x, pocket.y, 0), rim.r * along, rim.r * rim.u.cross(along)};
}

/// Depth behind wall or chamfer where that is the nearest way out, else kNoDepth. Behind the
/// material under the top face the way up may be shorter: that is the top face's contact.
double side_depth(const PocketProfile& pocket, double r, double z) {
  const double depth = pocket.behind_side(r, z);
  return -z < std::max(0.0, depth) ? kNoDepth : depth;
}

}  // namespace

void anchor_directions(const RimS& rim, const Vector3d& n, double sine, Vector3d& d1,
                       Vector3d& d2) {
  d1 = rim.e1;
  d2 = rim.e2;
  if (sine < kLevel) return;
  const Vector3d down = (n.dot(rim.u) * rim.u - n) / sine;
  if (sine >= kTilted) {
    d1 = down;
    d2 = rim.u.cross(down);
    return;
  }
  const double c = down.dot(rim.e1), s = down.dot(rim.e2);
  if (std::abs(c) < std::abs(s)) {
    d1 = s > 0 ? rim.e2 : Vector3d(-rim.e2);
  } else if (c < 0) {
    d1 = -rim.e1;
  }
  d2 = rim.u.cross(d1);
  const double turn = std::atan2(down.dot(d2), down.dot(d1)) * (sine - kLevel) / (kTilted - kLevel);
  const Vector3d b1 = d1;
  d1 = std::cos(turn) * b1 + std::sin(turn) * d2;
  d2 = rim.u.cross(d1);
}

RimInPocket rim_in_pocket(const RimS& rim, const PocketProfile& pocket) {
  const double off = std::hypot(rim.c.x() - pocket.x, rim.c.y() - pocket.y);
  if (off - rim.r > pocket.r_mouth || rim.r * std::abs(rim.u.z()) - off > pocket.r_mouth) {
    return RimInPocket::kApart;
  }
  const double low = rim.c.z() - rim.r * rim.sine;
  if (low >= 0) return RimInPocket::kApart;
  const bool above_floor = low > -pocket.depth;
  const double r_void = std::max(pocket.r_wall(low), pocket.r_mouth + pocket.chamfer_slope * low);
  if (above_floor && off + rim.r < r_void) return RimInPocket::kFree;
  return RimInPocket::kTouching;
}

void rim_on_pocket_side(const RimS& rim, const PocketProfile& pocket, Candidates& out) {
  const Basis basis = anchored(rim, pocket);
  const auto& directions = sample_directions();
  RingDepths depth;
  for (std::size_t i = 0; i < kRingSamples; ++i) {
    const Vector3d q = basis.c + directions[i].c * basis.a1 + directions[i].s * basis.a2;
    depth[i] = side_depth(pocket, std::sqrt(q.x() * q.x() + q.y() * q.y()), q.z());
  }
  const auto depth_at = [&](double angle) {
    const Vector3d q = basis.at(angle);
    return side_depth(pocket, std::hypot(q.x(), q.y()), q.z());
  };
  ring_maxima(depth, depth_at, [&](double angle) {
    const Vector3d q = basis.at(angle);
    const double r = std::hypot(q.x(), q.y());
    if (r < 1e-12) return;
    const bool wall = pocket.behind_wall(r, q.z()) <= pocket.behind_chamfer(r, q.z());
    const double cosine = wall ? pocket.wall_cos : pocket.chamfer_cos;
    const double slope = wall ? pocket.wall_slope : pocket.chamfer_slope;
    const Vector3d n(-q.x() / r * cosine, -q.y() / r * cosine, slope * cosine);
    out.add(q + Vector3d(pocket.x, pocket.y, 0), n, side_depth(pocket, r, q.z()));
  });
}

void rim_on_pocket_floor(const RimS& rim, const PocketProfile& pocket, Candidates& out) {
  if (rim.c.z() - rim.r * rim.sine >= -pocket.depth) return;
  Vector3d d1, d2;
  anchor_directions(rim, Vector3d::UnitZ(), rim.sine, d1, d2);
  for (const Vector3d& d : {d1, d2, Vector3d(-d1), Vector3d(-d2)}) {
    const Vector3d p = rim.c + rim.r * d;
    if (std::hypot(p.x() - pocket.x, p.y() - pocket.y) < pocket.r_floor + kCornerReach) {
      out.add(p, Vector3d::UnitZ(), -pocket.depth - p.z());
    }
  }
}

}  // namespace aprsim::physics::detail
