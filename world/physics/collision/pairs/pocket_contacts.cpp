#include "world/physics/collision/pairs/pocket_contacts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include "world/physics/collision/pairs/outline_contacts.hpp"
#include "world/physics/collision/pairs/polytope_contacts.hpp"
#include "world/physics/collision/shapes/length.hpp"
#include "world/physics/collision/shapes/pocket.hpp"

namespace aprsim::physics::detail {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// A penetration of a feature near a pocket beyond this is left to other features [m].
constexpr double kMostDeep = 1e-3;
constexpr double kFlatNormal = 0.99;  // cosine to the tray's z

/// Round pockets that one shape can reach at once.
struct NearbyPockets {
  static constexpr std::size_t kMost = 8;
  std::array<PocketProfile, kMost> items;
  std::size_t count = 0;

  NearbyPockets(const scene::TrayType& tray, const Vector2d& centre, double radius) {
    for (const scene::Slot& slot : tray.slots) {
      if (slot.pocket.outline) continue;
      const double reach = radius + PocketProfile(slot).r_mouth;
      if ((slot.xy - centre).squaredNorm() > reach * reach || count == kMost) continue;
      items[count++] = PocketProfile(slot);
    }
  }
  [[nodiscard]] const PocketProfile* begin() const { return items.data(); }
  [[nodiscard]] const PocketProfile* end() const { return items.data() + count; }
  [[nodiscard]] std::span<const PocketProfile> all() const { return {items.data(), count}; }
};

double radius_in(const PocketProfile& pocket, const Vector3d& p) {
  return length(p.x() - pocket.x, p.y() - pocket.y);
}

/// From the pocket's axis, unit; any at the axis itself.
Vector3d radial_at(const PocketProfile& pocket, const Vector3d& p) {
  const double r = radius_in(pocket, p);
  if (r < 1e-12) return Vector3d::UnitX();
  return {(p.x() - pocket.x) / r, (p.y() - pocket.y) / r, 0};
}

/// Whether a point under the top face is in the void of a pocket, or its wall or floor is a nearer
/// exit than `depth`.
bool belongs_to_pocket(const PocketProfile& pocket, const Vector3d& p, double depth) {
  const double below_floor = -pocket.depth - p.z();
  if (below_floor >= 0) {
    return length(below_floor, std::max(0.0, radius_in(pocket, p) - pocket.r_floor)) < depth;
  }
  return pocket.behind_side(radius_in(pocket, p), std::min(p.z(), 0.0)) < depth;
}

/// A polyhedron on a slab with pockets.
class PolytopeOnPockets {
 public:
  PolytopeOnPockets(const Polytope& polytope, const Isometry3d& X_PS, const Prism& slab,
                    const NearbyPockets& pockets, const NearbyOutlines& outlines, Candidates& out)
      : polytope_(polytope),
        X_PS_(X_PS),
        slab_(slab),
        pockets_(pockets),
        outlines_(outlines),
        out_(out) {}

  void find() {
    on_slab();
    for (const PocketProfile& pocket : pockets_) {
      for (const Polytope::Edge& edge : polytope_.edges) edge_in_pocket(pocket, edge);
      for (const Vector3d& corner : polytope_.corners) corner_on_floor(pocket, X_PS_ * corner);
      mouth_on_faces(pocket);
    }
    const TrayMaterial material{slab_, pockets_.all(), outlines_};
    for (const PocketOutline& pocket : outlines_) {
      polytope_in_outline(polytope_, X_PS_, pocket, material, out_);
    }
  }

 private:
  /// The contacts with the slab, without what lies over pockets. The edge of what is left runs
  /// along the mouths: their points belong to the support.
  void on_slab() {
    static thread_local Polytope slab;
    slab.set_prism(slab_);
    Candidates points;
    polytope_on_polytope(polytope_, X_PS_, slab, points);
    for (int i = 0; i < points.size(); ++i) {
      const Candidate& point = points[i];
      const bool lost = std::any_of(pockets_.begin(), pockets_.end(), [&](const auto& pocket) {
        return belongs_to_pocket(pocket, point.p, point.depth);
      });
      if (!lost && !outlines_.take(point.p, point.depth)) out_.add(point.p, point.n, point.depth);
      if (point.n.z() > kFlatNormal && points.size() > 1) {
        const Candidate& next = points[(i + 1) % points.size()];
        across_mouths(point, next);
        for (const PocketOutline& pocket : outlines_) across_outline(pocket, point, next, out_);
      }
    }
  }

  /// Where the line between two support points passes the edge of a mouth.
  void across_mouths(const Candidate& from, const Candidate& to) {
    for (const PocketProfile& pocket : pockets_) {
      const Vector2d p = from.p.head<2>() - Vector2d(pocket.x, pocket.y);
      const Vector2d d = to.p.head<2>() - from.p.head<2>();
      const double a = d.squaredNorm(), b = p.dot(d);
      const double root = b * b - a * (p.squaredNorm() - pocket.r_mouth * pocket.r_mouth);
      if (a == 0 || root <= 0) continue;
      for (const double sign : {-1.0, 1.0}) {
        const double t = (-b + sign * std::sqrt(root)) / a;
        if (t < 0 || t > 1) continue;
        const double depth = from.depth + t * (to.depth - from.depth);
        if (depth < kMostDeep) out_.add(from.p + t * (to.p - from.p), Vector3d::UnitZ(), depth);
      }
    }
  }

  /// The part of an edge in the pocket is farthest behind a cone at one of its ends, as the
  /// distance from an axis is convex along a line.
  void edge_in_pocket(const PocketProfile& pocket, const Polytope::Edge& edge) {
    Vector3d a = X_PS_ * polytope_.corner(edge.from), b = X_PS_ * polytope_.corner(edge.to);
    if (a.z() > b.z()) std::swap(a, b);
    if (a.z() >= 0 || b.z() <= -pocket.depth) return;
    const Vector3d d = b - a;
    const auto at_height = [&](double z) -> Vector3d {
      return d.z() > 0 ? Vector3d(a + (z - a.z()) / d.z() * d) : a;
    };
    const double low = std::max(a.z(), -pocket.depth), high = std::min(b.z(), 0.0);
    const double edge_z = std::clamp(pocket.z_edge, low, high);
    wall_point(pocket, at_height(low), -a.z());
    if (edge_z > low && edge_z < high) rim_point(pocket, at_height(edge_z), d, -a.z());
    if (high < 0) {
      wall_point(pocket, high > low ? b : a, -a.z());
    } else {
      rim_point(pocket, at_height(0), d, -a.z());
    }
  }

  /// A point of the polyhedron behind wall or chamfer. `up_m`: the way out over the top face.
  void wall_point(const PocketProfile& pocket, const Vector3d& p, double up_m) {
    const double r = radius_in(pocket, p);
    const double wall = pocket.behind_wall(r, p.z()), chamfer = pocket.behind_chamfer(r, p.z());
    const bool by_wall = !pocket.chamfered() || wall <= chamfer;
    const double depth = by_wall ? wall : chamfer;
    if (depth <= 0 || depth > std::min(kMostDeep, up_m)) return;
    const double slope = by_wall ? pocket.wall_slope : pocket.chamfer_slope;
    const double cosine = by_wall ? pocket.wall_cos : pocket.chamfer_cos;
    const Vector3d n = cosine * (slope * Vector3d::UnitZ() - radial_at(pocket, p));
    out_.add(p, n, depth);
  }

  /// An edge of direction d that passes a circular edge of the pocket at p: the normal is across
  /// both.
  void rim_point(const PocketProfile& pocket, const Vector3d& p, const Vector3d& d, double up_m) {
    const double rim = p.z() < 0 ? pocket.r_edge : pocket.r_mouth, r = radius_in(pocket, p);
    if (r <= rim || d.z() <= 0) return;
    const Vector3d radial = radial_at(pocket, p), tangent(-radial.y(), radial.x(), 0);
    Vector3d n = tangent.cross(d.normalized());
    const double sine = n.norm();
    constexpr double kAlong = 0.05;
    if (sine < kAlong) return;
    n /= n.dot(radial) > 0 ? -sine : sine;
    // Beyond the normals of wall and top face it is no contact of the rim.
    if (n.z() < 0) n = -radial;
    const double depth = (r - rim) * -n.dot(radial);
    if (depth < std::min(kMostDeep, up_m)) out_.add(p, n, depth);
  }

  void corner_on_floor(const PocketProfile& pocket, const Vector3d& p) {
    const double depth = -pocket.depth - p.z();
    if (depth <= 0 || depth > kMostDeep) return;
    if (radius_in(pocket, p) < pocket.r_floor + depth) out_.add(p, Vector3d::UnitZ(), depth);
  }

  /// Points of the mouth's edge inside the polyhedron: the deepest one behind each face, and eight
  /// around, which support a face over the mouth.
  void mouth_on_faces(const PocketProfile& pocket) {
    const Vector3d centre(pocket.x, pocket.y, 0);
    for (const Polytope::Face& face : polytope_.faces) {
      if (face.internal) continue;
      const Vector3d n = X_PS_.linear() * face.n;
      const double across = n.head<2>().norm();
      if (across < 1e-9) continue;
      mouth_point(centre - pocket.r_mouth / across * Vector3d(n.x(), n.y(), 0));
    }
    const Vector3d towards = X_PS_ * polytope_.middle - centre;
    const double start = std::atan2(towards.y(), towards.x());
    constexpr int kAround = 8;
    for (int k = 0; k < kAround; ++k) {
      const double angle = start + 2 * std::numbers::pi * k / kAround;
      mouth_point(centre + pocket.r_mouth * Vector3d(std::cos(angle), std::sin(angle), 0));
    }
  }

  void mouth_point(const Vector3d& p) {
    double depth = 1e30;
    Vector3d n = Vector3d::UnitZ();
    for (const Polytope::Face& face : polytope_.faces) {
      const Vector3d out = X_PS_.linear() * face.n;
      const double under = face.off + out.dot(X_PS_.translation()) - out.dot(p);
      if (under <= 0) return;
      if (face.internal || under >= depth) continue;
      depth = under;
      n = -out;
    }
    // Only directions out of the material there.
    if (depth < kMostDeep && n.z() > -1e-3) out_.add(p, n, depth);
  }

  const Polytope& polytope_;
  const Isometry3d& X_PS_;
  const Prism& slab_;
  const NearbyPockets& pockets_;
  const NearbyOutlines& outlines_;
  Candidates& out_;
};

/// A point of a circle about z, and how deep it lies in the capsule.
struct CapsuleDepth {
  const Segment& segment;
  double radius_m, half2;

  [[nodiscard]] Vector3d nearest(const Vector3d& p) const {
    if (half2 == 0) return segment.middle;
    return segment.at(std::clamp((p - segment.middle).dot(segment.half) / half2, -1.0, 1.0));
  }
  [[nodiscard]] double at(const Vector3d& p) const { return radius_m - (p - nearest(p)).norm(); }
};

/// The circular edge of a mouth in the capsule: local maxima of samples around, each refined by
/// golden section search (Press et al. 2007, sec. 10.2).
void mouth_on_capsule(const PocketProfile& pocket, double r, double z, const CapsuleDepth& capsule,
                      Candidates& out) {
  constexpr int kAround = 48;
  constexpr double kGolden = 0.6180339887498949, kSame = 1e-8;
  const auto point = [&](double angle) {
    return Vector3d(pocket.x + r * std::cos(angle), pocket.y + r * std::sin(angle), z);
  };
  const Vector3d towards = capsule.segment.middle - Vector3d(pocket.x, pocket.y, z);
  const double start = std::atan2(towards.y(), towards.x()), step = 2 * std::numbers::pi / kAround;
  std::array<double, kAround> depth{};
  for (int i = 0; i < kAround; ++i) {
    depth[static_cast<std::size_t>(i)] = capsule.at(point(start + step * i));
  }
  int found = 0;
  for (int i = 0; i < kAround && found < 4; ++i) {
    const auto own = static_cast<std::size_t>(i),
               last = static_cast<std::size_t>((i + kAround - 1) % kAround),
               next = static_cast<std::size_t>((i + 1) % kAround);
    if (depth[own] < depth[last] || depth[own] <= depth[next] - kSame) continue;
    double low = start + step * (i - 1), high = start + step * (i + 1);
    while (high - low > kSame) {
      const double m0 = high - kGolden * (high - low), m1 = low + kGolden * (high - low);
      (capsule.at(point(m0)) < capsule.at(point(m1)) ? low : high) =
          capsule.at(point(m0)) < capsule.at(point(m1)) ? m0 : m1;
    }
    const Vector3d p = point(0.5 * (low + high)), core = capsule.nearest(p);
    const double distance = (core - p).norm();
    if (distance < 1e-12 || distance >= capsule.radius_m) continue;
    const Vector3d n = (core - p) / distance;
    // Between the normals of the top face and of the wall.
    if (n.z() < 0 || n.dot(radial_at(pocket, p)) > 0) continue;
    out.add(p, n, capsule.radius_m - distance);
    ++found;
  }
}

/// An end of a capsule, as a ball, on wall and floor.
void ball_in_pocket(const PocketProfile& pocket, const Vector3d& c, double radius_m,
                    Candidates& out) {
  const double r = radius_in(pocket, c);
  if (c.z() < -pocket.depth || r > pocket.r_mouth) return;
  const double above_floor = c.z() + pocket.depth;
  if (r < pocket.r_floor) {
    out.add(c - radius_m * Vector3d::UnitZ(), Vector3d::UnitZ(), radius_m - above_floor);
  }
  // Distance from the wall's cone; its foot must be on the wall.
  const double gap = -pocket.behind_wall(r, c.z());
  const Vector3d n =
      pocket.wall_cos * (pocket.wall_slope * Vector3d::UnitZ() - radial_at(pocket, c));
  const Vector3d foot = c - gap * n;
  if (foot.z() > pocket.z_edge || foot.z() < -pocket.depth) return;
  if (r > 1e-9) out.add(c - radius_m * n, n, radius_m - gap);
}

}  // namespace

bool polytope_on_pocketed_slab(const Polytope& polytope, const Isometry3d& X_PS, const Prism& slab,
                               const scene::TrayType& tray, Candidates& out) {
  double radius = 0;
  for (const Vector3d& corner : polytope.corners) {
    radius = std::max(radius, (corner - polytope.middle).norm());
  }
  const Vector3d middle = X_PS * polytope.middle;
  if (middle.z() - radius > slab.z1) return false;
  const NearbyPockets pockets(tray, middle.head<2>(), radius);
  const NearbyOutlines outlines(tray, middle.head<2>(), radius);
  PolytopeOnPockets(polytope, X_PS, slab, pockets, outlines, out).find();
  return !outlines.empty();
}

bool capsule_on_pocketed_slab(const Segment& segment, double radius_m, const Prism& slab,
                              const scene::TrayType& tray, Candidates& out) {
  const double half = segment.half.norm();
  if (segment.middle.z() - half - radius_m > slab.z1) return false;
  const NearbyPockets pockets(tray, segment.middle.head<2>(), half + radius_m);
  const NearbyOutlines outlines(tray, segment.middle.head<2>(), half + radius_m);
  Candidates points;
  capsule_on(
      segment, radius_m, [&slab](const Vector3d& p) { return nearness(slab, p); }, points);
  for (int i = 0; i < points.size(); ++i) {
    // The foot on the slab's surface is where the contact is.
    const Vector3d foot = points[i].p + points[i].depth * points[i].n;
    const bool lost = std::any_of(pockets.begin(), pockets.end(), [&](const auto& pocket) {
      return foot.z() > -pocket.depth && radius_in(pocket, foot) < pocket.r_mouth;
    });
    if (!lost && !outlines.take(foot, 0)) out.add(points[i].p, points[i].n, points[i].depth);
  }
  const CapsuleDepth capsule{segment, radius_m, segment.half.squaredNorm()};
  for (const PocketProfile& pocket : pockets) {
    mouth_on_capsule(pocket, pocket.r_mouth, 0, capsule, out);
    if (pocket.chamfered()) mouth_on_capsule(pocket, pocket.r_edge, pocket.z_edge, capsule, out);
    ball_in_pocket(pocket, segment.at(-1), radius_m, out);
    if (half > 0) ball_in_pocket(pocket, segment.at(1), radius_m, out);
  }
  const TrayMaterial material{slab, pockets.all(), outlines};
  for (const PocketOutline& pocket : outlines) {
    capsule_in_outline(segment, radius_m, pocket, material, out);
  }
  return !outlines.empty();
}

}  // namespace aprsim::physics::detail
