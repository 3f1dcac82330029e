#include "world/physics/collision/pairs/rim_vs_pocket.hpp"

#include <algorithm>
#include <cmath>

#include "world/base/simd/vector_clones.hpp"
#include "world/physics/collision/pairs/circle_maxima.hpp"
#include "world/physics/collision/shapes/length.hpp"

// A circle (rim of a hub) against a surface of revolution (pocket with wall and chamfer cones). In
// a fixed meridian the pocket is a polygon, so that depth is exact at a point; around the rim the
// local maxima of depth are searched (circle_maxima.hpp). A peg that leans in a hole has two such
// contacts, on opposite sides (Whitney 1982, two-point contact in part mating).
namespace aprsim::physics::detail {
namespace {

using Eigen::Vector3d;

/// Tilt (sine) below which the points are body-fixed, and above which they follow the tilt. On a
/// disc of 50 mm the blend spans 5 to 25 um of height.
constexpr double kLevel = 1e-4, kTilted = 5e-4;

/// At the mouth's corner the exits up and sideways differ by less than this factor.
constexpr double kMouthCorner = 3;

/// Samples start in the direction in which the rim is off the pocket's axis.
CircleBasis anchored(const RimS& rim, const PocketProfile& pocket) {
  // The deepest point of an upright rim is where its centre is off the axis. The first sample there
  // makes a seated hub's contact exact.
  const Vector3d d(rim.c.x() - pocket.x, rim.c.y() - pocket.y, 0);
  Vector3d along = d - d.dot(rim.u) * rim.u;
  const double norm = along.norm();
  along = norm > 1e-10 ? Vector3d(along / norm) : rim.e1;
  return {rim.c, rim.r * along, rim.r * rim.u.cross(along)};
}

/// Surface of an exit. From kElsewhere on: the slab's sides in their order.
enum PocketExit : int {
  kWall = 0,
  kChamfer = 1,
  kTopFace = 2,
  kElsewhere = 3,
  kBelow = kElsewhere + Prism::kMaxSides
};

/// Nearest exit of the material around the pocket at p (tray frame), r from the pocket's axis: into
/// the pocket through wall or chamfer, up, or through the slab's sides.
PenetrationExit pocket_exit(const PocketProfile& pocket, const Prism& slab, const Vector3d& p,
                            double r) {
  PenetrationExit exit{pocket.behind_wall(r, p.z()), kWall};
  // Later faces replace earlier ones only if strictly nearer; ties go to the wall.
  const auto nearer = [&exit](double depth, int kind) {
    if (depth < exit.depth) exit = {depth, kind};
  };
  nearer(pocket.behind_chamfer(r, p.z()), kChamfer);
  nearer(-p.z(), kTopFace);
  for (int i = 0; i < slab.sides; ++i) {
    const auto k = static_cast<std::size_t>(i);
    nearer(slab.off[k] - slab.n[k].dot(p.head<2>()), kElsewhere + i);
  }
  const double above = p.z() - slab.z0;
  if (above < 0) nearer(above, kBelow);
  return exit;
}

/// Under the floor the pocket has no sides.
bool under_floor(const PocketProfile& pocket, double z) { return z < -pocket.depth - kCornerReach; }

/// Whether an exit upwards belongs to the top face. It is the pocket's only at the mouth's corner.
bool beyond_corner(double behind_side, double exit_up) {
  return behind_side > kMouthCorner * exit_up;
}

/// Peaks of the depth that pocket_exit() has, without those that belong to the top face or are
/// under the floor.
APRSIM_VECTOR_CLONES void sample(const PocketProfile& pocket, const Prism& slab, const RimS& rim,
                                 const CircleBasis& basis, CandidateSamples& peaks) {
  const CircleSamples x = basis.samples(0), y = basis.samples(1), z = basis.samples(2);
  ClosedCircleSamples depth, wall, chamfer, sides, height;
  CircleSamples most, used;
  sides.fill(1e30);
  for (int side = 0; side < slab.sides; ++side) {
    const auto k = static_cast<std::size_t>(side);
    const double n_x = slab.n[k].x(), n_y = slab.n[k].y(), off = slab.off[k];
    for (std::size_t i = 0; i < kCircleSamples; ++i) {
      sides[i] = std::min(sides[i], off - (n_x * x[i] + n_y * y[i]));
    }
  }
  for (std::size_t i = 0; i < kCircleSamples; ++i) {
    const double dx = x[i] - pocket.x, dy = y[i] - pocket.y;
    const double r = std::sqrt(dx * dx + dy * dy);
    wall[i] = pocket.behind_wall(r, z[i]);
    chamfer[i] = pocket.behind_chamfer(r, z[i]);
    height[i] = z[i];
    const double least = std::min(std::min(wall[i], chamfer[i]), std::min(-z[i], sides[i]));
    const double above = z[i] - slab.z0;
    depth[i] = above < 0 ? std::min(least, above) : least;
  }
  for (auto* values : {&depth, &wall, &chamfer, &sides, &height}) values->back() = values->front();
  // Bounds between two samples: the height bulges by that of the rim, the depths behind wall and
  // chamfer by the least second derivative of radius and height. No depth grows faster than the
  // arc.
  const double off = length(rim.c.x() - pocket.x, rim.c.y() - pocket.y), r_max = off + rim.r;
  const double across = std::max(0.0, rim.r * (rim.r * std::abs(rim.u.z()) - off));
  const double bend = off + r_max - across * across / (r_max * r_max * r_max);
  const double rise = rim.r * rim.sine;
  const double half_arc = 0.5 * kSampleAngle * rim.r;
  const auto bulge = [&](double slope, double cosine) {
    return std::min(half_arc, kSampleBulge * (bend + std::abs(slope) * rise) * cosine) +
           kBoundSlack;
  };
  const double over_wall = bulge(pocket.wall_slope, pocket.wall_cos);
  const double over_chamfer = bulge(pocket.chamfer_slope, pocket.chamfer_cos);
  const double over = kSampleBulge * rise + kBoundSlack;
  for (std::size_t i = 0; i < kCircleSamples; ++i) {
    const double wall_a = wall[i] + over_wall, wall_b = wall[i + 1] + over_wall;
    const double chamfer_a = chamfer[i] + over_chamfer, chamfer_b = chamfer[i + 1] + over_chamfer;
    const double top_a = over - height[i], top_b = over - height[i + 1];
    const double z_most = over + std::max(height[i], height[i + 1]), above = z_most - slab.z0;
    const double within = 0.5 * (sides[i] + sides[i + 1]) + half_arc + kBoundSlack;
    const double through = std::min(upper_bound_of_min(wall_a, wall_b, top_a, top_b),
                                    upper_bound_of_min(chamfer_a, chamfer_b, top_a, top_b));
    most[i] = std::min(through, std::min(above, within));
    const double side =
        0.5 * std::min(wall[i] + wall[i + 1], chamfer[i] + chamfer[i + 1]) - half_arc;
    used[i] = std::min(z_most + pocket.depth + kCornerReach,
                       kMouthCorner * std::max(top_a, top_b) - side);
  }
  peaks = find_candidate_samples(depth, most, rim.r);
  discard_irrelevant(used, peaks);
}

/// The same for a point of a circle.
ExitWithGradient pocket_exit_along(const PocketProfile& pocket, const Prism& slab,
                                   const CirclePoint& at) {
  const double x = at.p.x() - pocket.x, y = at.p.y() - pocket.y, r = length(x, y);
  const Vector3d& on = at.by_step;
  ExitWithGradient exit{pocket_exit(pocket, slab, at.p, r)};
  if (exit.kind == kWall || exit.kind == kChamfer) {
    const double r_on = x * on.x() + y * on.y();  // times r
    exit.turn = exit.kind == kWall
                    ? (r_on - pocket.wall_slope * on.z() * r) * pocket.wall_cos
                    : (r_on - pocket.chamfer_slope * on.z() * r) * pocket.chamfer_cos;
    exit.slope = r > 0 ? exit.turn / r : 0;
    return exit;
  }
  exit.excluded = exit.kind == kBelow;
  if (exit.kind == kTopFace || exit.kind == kBelow) {
    exit.slope = exit.kind == kTopFace ? -on.z() : on.z();
  } else {
    exit.slope = -slab.n[static_cast<std::size_t>(exit.kind - kElsewhere)].dot(on.head<2>());
  }
  exit.turn = exit.slope;
  return exit;
}

}  // namespace

void anchor_directions(const RimS& rim, const Vector3d& n, double sine, Vector3d& d1,
                       Vector3d& d2) {
  // Level: body-fixed. Tilted: towards the deepest point.
  d1 = rim.e1;
  d2 = rim.e2;
  // On a level rim the deepest direction is undefined; body-fixed points keep their identity from
  // step to step, which the warm start needs.
  if (sine < kLevel) return;
  const Vector3d down = (n.dot(rim.u) * rim.u - n) / sine;
  if (sine >= kTilted) {
    d1 = down;
    d2 = rim.u.cross(down);
    return;
  }
  // Between: turned from the nearest body-fixed radius towards the deepest point.
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
  const double off = length(rim.c.x() - pocket.x, rim.c.y() - pocket.y);
  if (off - rim.r > pocket.r_mouth || rim.r * std::abs(rim.u.z()) - off > pocket.r_mouth) {
    return RimInPocket::kApart;
  }
  // Decided by the rim's lowest point and the pocket's radius there.
  const double low = rim.c.z() - rim.r * rim.sine;
  if (low >= 0) return RimInPocket::kApart;
  const bool above_floor = low > -pocket.depth;
  // Both cones widen upwards, so that the lowest point of the rim has the least room.
  const double r_void = std::max(pocket.r_wall(low), pocket.r_mouth + pocket.chamfer_slope * low);
  if (above_floor && off + rim.r < r_void) return RimInPocket::kFree;
  return RimInPocket::kTouching;
}

void rim_on_pocket_side(const RimS& rim, const PocketProfile& pocket, const Prism& slab,
                        Candidates& out) {
  const CircleBasis basis = anchored(rim, pocket);
  // Sampled around the rim; the local maxima of depth are refined.
  CandidateSamples peaks;
  sample(pocket, slab, rim, basis, peaks);
  const auto exit_at = [&](const CirclePoint& at) { return pocket_exit_along(pocket, slab, at); };
  circle_extrema(peaks, basis, rim.r, exit_at, [&](const CircleMaximum& found) {
    const Vector3d& p = found.at.p;
    const double x = p.x() - pocket.x, y = p.y() - pocket.y, r = length(x, y);
    const PenetrationExit& exit = found.exit;
    if (r < 1e-12 || exit.kind >= kElsewhere) return;
    if (under_floor(pocket, p.z())) return;
    Vector3d n = Vector3d::UnitZ();
    if (exit.kind == kTopFace) {
      if (beyond_corner(pocket.behind_side(r, p.z()), exit.depth)) return;
    } else {
      const double cosine = exit.kind == kWall ? pocket.wall_cos : pocket.chamfer_cos;
      const double slope = exit.kind == kWall ? pocket.wall_slope : pocket.chamfer_slope;
      // Normal out of the material: towards the axis, tilted up by the cone's slope.
      n << -x / r * cosine, -y / r * cosine, slope * cosine;
    }
    out.add(p, n, exit.depth);
  });
}

void rim_on_pocket_floor(const RimS& rim, const PocketProfile& pocket, double underside,
                         Candidates& out) {
  if (rim.c.z() - rim.r * rim.sine >= -pocket.depth) return;
  Vector3d d1, d2;
  anchor_directions(rim, Vector3d::UnitZ(), rim.sine, d1, d2);
  for (const Vector3d& d : {d1, d2, Vector3d(-d1), Vector3d(-d2)}) {
    const Vector3d p = rim.c + rim.r * d;
    if (p.z() > underside &&
        length(p.x() - pocket.x, p.y() - pocket.y) < pocket.r_floor + kCornerReach) {
      out.add(p, Vector3d::UnitZ(), -pocket.depth - p.z());
    }
  }
}

}  // namespace aprsim::physics::detail
