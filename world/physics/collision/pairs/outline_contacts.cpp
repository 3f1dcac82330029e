#include "world/physics/collision/pairs/outline_contacts.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "world/physics/collision/pairs/gear_vs_prism.hpp"
#include "world/physics/collision/shapes/length.hpp"
#include "world/physics/collision/shapes/nearness.hpp"
#include "world/physics/collision/shapes/wall_piece.hpp"

namespace aprsim::physics::detail {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// A penetration of a feature near a pocket beyond this is left to other features [m].
constexpr double kDeepestFeature = 1e-3;
constexpr double kAlongSurface = 1e-3;  // cosine: a normal along a surface

Vector3d horizontal(const Vector2d& v) { return {v.x(), v.y(), 0}; }

/// A polyhedron in one pocket.
class PolytopeInOutline {
 public:
  PolytopeInOutline(const Polytope& polytope, const Isometry3d& X_PS, const PocketOutline& pocket,
                    const TrayMaterial& material, Candidates& out)
      : polytope_(polytope), X_PS_(X_PS), pocket_(pocket), material_(material), out_(out) {}

  void find() {
    for (const Polytope::Edge& edge : polytope_.edges) edge_on_sides(edge);
    for (const Vector3d& corner : polytope_.corners) corner_on_floor(X_PS_ * corner);
    for (std::size_t i = 0; i < pocket_.sides; ++i) mouth_in_polytope(i);
  }

 private:
  /// The part of an edge in the pocket is farthest behind a plane at one of its ends, or where it
  /// passes the edge between wall and chamfer.
  void edge_on_sides(const Polytope::Edge& edge) {
    Vector3d a = X_PS_ * polytope_.corner(edge.from), b = X_PS_ * polytope_.corner(edge.to);
    if (a.z() > b.z()) std::swap(a, b);
    if (a.z() >= 0 || b.z() <= -pocket_.depth) return;
    const Vector3d d = b - a;
    const auto at_height = [&](double z) -> Vector3d {
      return d.z() > 0 ? Vector3d(a + (z - a.z()) / d.z() * d) : a;
    };
    const double low = std::max(a.z(), -pocket_.depth), high = std::min(b.z(), 0.0);
    const double edge_z = std::clamp(pocket_.z_edge, low, high), up_m = -a.z();
    wall_point(at_height(low), up_m);
    if (edge_z > low && edge_z < high) rim_point(at_height(edge_z), d, 0, up_m);
    if (high < 0) {
      if (high > low) wall_point(b, up_m);
    } else {
      rim_point(at_height(0), d, pocket_.width, up_m);
    }
  }

  /// A point of the polyhedron behind walls or chamfers. `up_m`: the way out over the top face.
  void wall_point(const Vector3d& p, double up_m) {
    const double most = pocket_.behind(p);
    if (most <= 0 || most > std::min(kDeepestFeature, up_m) || !material_.holds(pocket_, p, most))
      return;
    for (std::size_t i = 0; i < pocket_.sides; ++i) {
      const double wall = pocket_.beyond(i, p);
      const bool by_chamfer = pocket_.chamfered() && pocket_.behind_chamfer(i, p) < wall;
      Vector3d n = -horizontal(pocket_.normals[i]);
      if (by_chamfer) {
        n = pocket_.chamfer_cos * (n + pocket_.chamfer_slope * Vector3d::UnitZ());
      }
      out_.add(p, n, by_chamfer ? pocket_.behind_chamfer(i, p) : wall);
    }
  }

  /// An edge of direction d that passes an edge of the pocket, `by` outwards of the walls, at p:
  /// the normal is across both.
  void rim_point(const Vector3d& p, const Vector3d& d, double by, double up_m) {
    constexpr double kAlong = 0.05;
    if (d.z() <= 0) return;
    double most = 0;
    for (std::size_t i = 0; i < pocket_.sides; ++i) {
      most = std::max(most, pocket_.beyond(i, p) - by);
    }
    const double limit = std::min(kDeepestFeature, up_m);
    if (most <= 0 || most > kDeepestFeature || !material_.holds(pocket_, p, most)) return;
    const Vector3d along = d.normalized();
    for (std::size_t i = 0; i < pocket_.sides; ++i) {
      const double beyond = pocket_.beyond(i, p) - by;
      if (beyond <= 0) continue;
      const Vector3d out = horizontal(pocket_.normals[i]), tangent(-out.y(), out.x(), 0);
      Vector3d n = tangent.cross(along);
      const double sine = n.norm();
      if (sine < kAlong) continue;
      n /= n.dot(out) > 0 ? -sine : sine;
      // Beyond the normals of wall and top face it is no contact of the rim.
      if (n.z() < 0) n = -out;
      const double depth = beyond * -n.dot(out);
      if (depth < limit) out_.add(p, n, depth);
    }
  }

  void corner_on_floor(const Vector3d& p) {
    const double depth = -pocket_.depth - p.z();
    if (depth <= 0 || depth > kDeepestFeature) return;
    for (std::size_t i = 0; i < pocket_.sides; ++i) {
      if (pocket_.beyond(i, p) > depth) return;
    }
    out_.add(p, Vector3d::UnitZ(), depth);
  }

  /// A corner of the mouth inside the polyhedron, behind the nearest face.
  void mouth_in_polytope(std::size_t i) {
    const Vector3d p = horizontal(pocket_.corner(i, pocket_.width));
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
    const bool out_of_it = n.z() > -kAlongSurface &&
                           n.dot(horizontal(pocket_.normals[i])) < kAlongSurface &&
                           n.dot(horizontal(pocket_.normals[pocket_.last(i)])) < kAlongSurface;
    if (depth < kDeepestFeature && out_of_it) out_.add(p, n, depth);
  }

  const Polytope& polytope_;
  const Isometry3d& X_PS_;
  const PocketOutline& pocket_;
  const TrayMaterial& material_;
  Candidates& out_;
};

/// Adds those contacts of a piece of the pocket's material that are contacts of the tray.
/// `foot(c)`: the contact's point on the tray's surface.
template <class Foot>
void add_of_tray(const Candidates& found, const PocketOutline& pocket, const TrayMaterial& material,
                 const Foot& foot, Candidates& out) {
  for (int i = 0; i < found.size(); ++i) {
    const Candidate& c = found[i];
    if (c.depth < kDeepestFeature && material.holds(pocket, foot(c), 0)) out.add(c.p, c.n, c.depth);
  }
}

}  // namespace

NearbyOutlines::NearbyOutlines(const scene::TrayType& tray, const Vector2d& centre, double radius) {
  for (const scene::Slot& slot : tray.slots) {
    if (!slot.pocket.outline || count_ == kMost) continue;
    PocketOutline& pocket = items_[count_];
    pocket = PocketOutline(slot);
    const double reach = radius + pocket.radius;
    if ((pocket.middle - centre).squaredNorm() <= reach * reach) ++count_;
  }
}

bool NearbyOutlines::take(const Vector3d& p, double depth) const {
  return std::any_of(begin(), end(),
                     [&](const PocketOutline& pocket) { return pocket.takes(p, depth); });
}

void NearbyOutlines::keep_on_slab(const Candidates& on_slab, Candidates& out) const {
  for (int i = 0; i < on_slab.size(); ++i) {
    const Candidate& point = on_slab[i];
    if (!take(point.p, point.depth)) out.add(point.p, point.n, point.depth);
  }
}

bool TrayMaterial::holds(const PocketOutline& own, const Vector3d& p, double depth) const {
  constexpr double kSurface = 1e-6;  // [m]
  for (int i = 0; i < slab.sides; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double under = slab.off[k] - slab.n[k].dot(p.head<2>());
    if (under < std::max(-kSurface, depth - kSurface)) return false;
  }
  for (const PocketProfile& other : round) {
    const double side = other.behind_side(length(p.x() - other.x, p.y() - other.y), p.z());
    if (p.z() > -other.depth && side < depth - kSurface) return false;
  }
  for (const PocketOutline& other : outlines) {
    const bool itself = other.middle == own.middle;
    if (!itself && p.z() > -other.depth && other.behind(p) < depth - kSurface) return false;
  }
  return true;
}

void across_outline(const PocketOutline& pocket, const Candidate& from, const Candidate& to,
                    Candidates& out) {
  // The segment clipped by the mouth's sides (Cyrus and Beck 1978).
  double enter = 0, leave = 1;
  for (std::size_t i = 0; i < pocket.sides; ++i) {
    const double a = pocket.beyond(i, from.p) - pocket.width;
    const double b = pocket.beyond(i, to.p) - pocket.width;
    if (a > 0 && b > 0) return;
    if (a > 0) enter = std::max(enter, a / (a - b));
    if (b > 0) leave = std::min(leave, a / (a - b));
  }
  if (enter >= leave) return;
  for (const double t : {enter, leave}) {
    const double depth = from.depth + t * (to.depth - from.depth);
    if (t > 0 && t < 1 && depth < kDeepestFeature) {
      out.add(from.p + t * (to.p - from.p), Vector3d::UnitZ(), depth);
    }
  }
}

void polytope_in_outline(const Polytope& polytope, const Isometry3d& X_PS,
                         const PocketOutline& pocket, const TrayMaterial& material,
                         Candidates& out) {
  // A body under the tray touches its underside only.
  if ((X_PS * polytope.middle).z() < -pocket.depth) return;
  PolytopeInOutline(polytope, X_PS, pocket, material, out).find();
}

void gear_in_outline(const GearShape& gear, const Isometry3d& X_PG, const PocketOutline& pocket,
                     const TrayMaterial& material, Candidates& out) {
  if ((X_PG * gear.middle()).z() < -pocket.depth) return;
  const auto foot = [](const Candidate& c) -> const Vector3d& { return c.p; };
  Candidates on_floor;
  Prism floor;
  set_floor_piece(pocket, material.slab.z0, floor);
  gear_on_prism(gear, X_PG, floor, {}, on_floor);
  add_of_tray(on_floor, pocket, material, foot, out);
  thread_local Polytope wall;
  for (std::size_t i = 0; i < pocket.sides; ++i) {
    Candidates on_wall;
    set_wall_piece(pocket, i, material.slab.z0, wall);
    gear_on_polytope(gear, X_PG, wall, on_wall);
    add_of_tray(on_wall, pocket, material, foot, out);
  }
}

void capsule_in_outline(const Segment& segment, double radius_m, const PocketOutline& pocket,
                        const TrayMaterial& material, Candidates& out) {
  if (segment.middle.z() < -pocket.depth) return;
  const auto foot = [](const Candidate& c) -> Vector3d { return c.p + c.depth * c.n; };
  Candidates found;
  Prism floor;
  set_floor_piece(pocket, material.slab.z0, floor);
  capsule_on(
      segment, radius_m, [&floor](const Vector3d& p) { return nearness(floor, p); }, found);
  thread_local Polytope wall;
  for (std::size_t i = 0; i < pocket.sides; ++i) {
    set_wall_piece(pocket, i, material.slab.z0, wall);
    capsule_on(
        segment, radius_m, [](const Vector3d& p) { return nearness(wall, p); }, found);
  }
  add_of_tray(found, pocket, material, foot, out);
}

}  // namespace aprsim::physics::detail
