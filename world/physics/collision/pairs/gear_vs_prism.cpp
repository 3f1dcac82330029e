#include "world/physics/collision/pairs/gear_vs_prism.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "world/base/simd/vector_clones.hpp"
#include "world/physics/collision/pairs/circle_maxima.hpp"
#include "world/physics/collision/pairs/rim_vs_pocket.hpp"
#include "world/physics/collision/pairs/straight_edge_vs_gear.hpp"
#include "world/physics/collision/shapes/length.hpp"

// The gear's rims against the prism's planes and pockets, and the prism's edges against the gear's
// pieces: both contain the points of a convex body against another that are farthest inside. A rim
// point belongs to the face that is its nearest exit.
//
// The deepest features of two convex bodies are vertices, edges or faces (Ericson 2005, ch. 5.1 and
// 5.2). A solid of revolution has circles as its edges: their deepest points have closed forms
// against planes, and are searched numerically against cones. The exit of a point is the least
// translation that takes it out (Cameron & Culley 1986, minimum translational distance).
// Deep penetration is resolved towards the faces on the gear's side of the prism.
namespace aprsim::physics::detail {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr int kMaxPlanes = static_cast<int>(Polytope::kMaxFaces);
static_assert(kMaxPlanes >= Prism::kMaxSides + 2);
constexpr int kTop = 0, kBottom = 1;

/// A face plane of the prism and how the gear lies to it.
struct Plane {
  Vector3d n;
  double off;
  double along, sine;  ///< of the angle between n and the gear's axis
  bool crossed;        ///< the gear's bounds lie on both sides
  bool exit;           ///< the gear may be pushed out through it
  bool internal;       ///< towards another part of the same body
  [[nodiscard]] double under(const Vector3d& p) const { return off - n.dot(p); }
};

/// The gear and the prism, in the prism's frame S: c, u, e1, e2 are the gear's frame.
struct Pair {
  const GearShape& gear;
  const Isometry3d& X_SG;
  const Prism& prism;
  std::span<const PocketProfile> pockets;
  Vector3d c, u, e1, e2;
  std::array<Plane, kMaxPlanes> planes;  ///< set by set_planes() and classify_planes()
  int plane_count = 0;
  int crossed_count = 0, exit_count = 0;

  Pair(const GearShape& shape, const Isometry3d& X, const Prism& p,
       std::span<const PocketProfile> holes)
      : gear(shape),
        X_SG(X),
        prism(p),
        pockets(holes),
        c(X.translation()),
        u(X.linear().col(2)),
        e1(X.linear().col(0)),
        e2(X.linear().col(1)) {}
};

/// Rotates the support points of a gear in a pocket towards where it leans on the wall, because it
/// would tip there. Four body-fixed points lack up to 29 % of the rim's support.
void turn_to_pocket(Pair& pair) {
  constexpr double kCentred = 2e-5, kOff = 6e-5;  // [m] off the pocket's axis: body-fixed, turned
  for (const PocketProfile& pocket : pair.pockets) {
    const Vector3d off(pair.c.x() - pocket.x, pair.c.y() - pocket.y, 0);
    const double distance = off.norm();
    if (distance > pocket.r_mouth) continue;
    const double share = std::clamp((distance - kCentred) / (kOff - kCentred), 0.0, 1.0);
    if (share == 0) return;
    // A rotation by less than 45 degrees suffices: the four support points repeat every quarter
    // turn.
    const double quarter = 0.5 * std::numbers::pi;
    const double angle = std::atan2(off.dot(pair.e2), off.dot(pair.e1));
    const double turn = share * (angle - quarter * std::round(angle / quarter));
    pair.e1 = (std::cos(turn) * pair.e1 + std::sin(turn) * pair.e2).eval();
    pair.e2 = pair.u.cross(pair.e1);
    return;
  }
}

/// Top, bottom, then the sides.
void set_planes(Pair& pair) {
  const Prism& prism = pair.prism;
  pair.planes[kTop].n = Vector3d::UnitZ();
  pair.planes[kTop].off = prism.z1;
  pair.planes[kTop].internal = pair.planes[kBottom].internal = false;
  pair.planes[kBottom].n = -Vector3d::UnitZ();
  pair.planes[kBottom].off = -prism.z0;
  for (int i = 0; i < prism.sides; ++i) {
    const auto k = static_cast<std::size_t>(i);
    pair.planes[k + 2].n = Vector3d(prism.n[k].x(), prism.n[k].y(), 0);
    pair.planes[k + 2].off = prism.off[k];
    pair.planes[k + 2].internal = prism.internal[k];
  }
  pair.plane_count = prism.sides + 2;
}

void set_planes(Pair& pair, const Polytope& polytope) {
  for (std::size_t i = 0; i < polytope.faces.size(); ++i) {
    pair.planes[i].n = polytope.faces[i].n;
    pair.planes[i].off = polytope.faces[i].off;
    pair.planes[i].internal = polytope.faces[i].internal;
  }
  pair.plane_count = static_cast<int>(polytope.faces.size());
}

/// Finds the planes the gear's bounding cylinder crosses; false when one of them keeps it outside.
bool classify_planes(Pair& pair) {
  const GearShape& gear = pair.gear;
  const Vector3d centre = pair.c + 0.5 * (gear.z_low + gear.z_high) * pair.u;
  const double half = 0.5 * (gear.z_high - gear.z_low);
  std::array<bool, kMaxPlanes> facing{};
  for (int i = 0; i < pair.plane_count; ++i) {
    Plane& plane = pair.planes[static_cast<std::size_t>(i)];
    plane.along = plane.n.dot(pair.u);
    plane.sine = std::sqrt(std::max(0.0, 1 - plane.along * plane.along));
    // Support of a cylinder along n: half length times |cos| plus radius times sin.
    const double reach = half * std::abs(plane.along) + gear.r_max * plane.sine;
    const double under = plane.under(centre);
    if (under <= -reach) return false;
    plane.crossed = under < reach;
    pair.crossed_count += plane.crossed;
    // A face behind the prism's middle, as seen from the gear, would be an exit right through the
    // prism.
    facing[static_cast<std::size_t>(i)] = !plane.internal && under < plane.under(pair.prism.middle);
    plane.exit = plane.crossed && facing[static_cast<std::size_t>(i)];
    pair.exit_count += plane.exit;
  }
  if (pair.exit_count > 0) return true;
  // Wholly inside: exits on the side of the gear's offset from the middle, or the top.
  for (int i = 0; i < pair.plane_count; ++i) {
    const bool exit = facing[static_cast<std::size_t>(i)];
    pair.planes[static_cast<std::size_t>(i)].exit = exit;
    pair.exit_count += exit;
  }
  if (pair.exit_count == 0) {
    pair.planes[kTop].exit = true;
    pair.exit_count = 1;
  }
  return true;
}

/// How a piece of the gear lies to the faces: moved by `overlap` along the normal of `face` it is
/// free of the prism, and no other face takes less.
struct Resting {
  bool apart = false;
  int face = -1;
  double overlap = 1e30;
};

Resting resting(const Pair& pair, const Piece& piece) {
  Resting result;
  for (int i = 0; i < pair.plane_count; ++i) {
    const Plane& plane = pair.planes[static_cast<std::size_t>(i)];
    if (!plane.crossed && !plane.exit) continue;
    // A frustum's support is at one of its two rims.
    const double low = plane.under(pair.c + piece.z0 * pair.u) + piece.r0 * plane.sine;
    const double high = plane.under(pair.c + piece.z1 * pair.u) + piece.r1 * plane.sine;
    const double overlap = std::max(low, high);
    if (overlap <= 0) return {true, -1, 0};
    if (plane.exit && overlap < result.overlap) {
      result.overlap = overlap;
      result.face = i;
    }
  }
  return result;
}

/// Pockets near a rim that it may touch.
struct RimPockets {
  static constexpr int kMax = 8;
  std::array<const PocketProfile*, kMax> touching;
  int count = 0;
  bool free = false;  ///< wholly in one pocket's void
};

RimPockets pockets_of(const RimS& rim, std::span<const PocketProfile> pockets) {
  RimPockets found;
  for (const PocketProfile& pocket : pockets) {
    const RimInPocket where = rim_in_pocket(rim, pocket);
    if (where == RimInPocket::kFree) found.free = true;
    if (where == RimInPocket::kTouching && found.count < RimPockets::kMax) {
      found.touching[static_cast<std::size_t>(found.count++)] = &pocket;
    }
  }
  return found;
}

/// Whether the gear leaves through the underside. It then has not entered through a pocket's floor.
bool comes_from_below(const Pair& pair) { return pair.planes[kBottom].exit; }

/// Distance from a point in the material, below its top, into a pocket.
double exit_into_pocket(const PocketProfile& pocket, const Vector3d& p) {
  const double r = length(p.x() - pocket.x, p.y() - pocket.y);
  const double below = -pocket.depth - p.z();
  return below < 0 ? pocket.behind_side(r, p.z())
                   : length(below, std::max(0.0, r - pocket.r_floor));
}

/// Whether the point, `depth` below a face, is in the material and no pocket is a nearer exit.
bool held_by_pockets(const Pair& pair, const RimPockets& near, const Vector3d& p, double depth) {
  for (int i = 0; i < near.count; ++i) {
    const PocketProfile& pocket = *near.touching[static_cast<std::size_t>(i)];
    // Below a floor there is only the slab; its exit is the underside.
    if (p.z() <= -pocket.depth && comes_from_below(pair)) continue;
    if (exit_into_pocket(pocket, p) < depth) return false;
  }
  return true;
}

/// Is the point inside the prism, and unless `decided` is face f the nearest exit?
bool held_by_face(const Pair& pair, int f, bool decided, const Vector3d& p, double depth) {
  if (pair.crossed_count <= 1 && pair.exit_count <= 1) return true;
  for (int i = 0; i < pair.plane_count; ++i) {
    const Plane& plane = pair.planes[static_cast<std::size_t>(i)];
    // Planes that the gear's bounds do not cross cannot be nearer than the face itself.
    if (i == f || (!plane.crossed && !plane.exit)) continue;
    const double under = plane.under(p);
    if (under < 0 || (!decided && plane.exit && under < depth)) return false;
  }
  return true;
}

/// Four points of a rim below face f.
void rim_on_face(const Pair& pair, const RimS& rim, int f, const Resting& rest,
                 const RimPockets& near, Candidates& out) {
  constexpr double kDeepest = 0.9;       // share of the overlap
  constexpr double kMostDecided = 1e-3;  // [m]
  const Plane& plane = pair.planes[static_cast<std::size_t>(f)];
  if (plane.under(rim.c) + rim.r * plane.sine <= 0) return;
  Vector3d d1, d2;
  anchor_directions(rim, plane.n, plane.sine, d1, d2);
  for (const Vector3d& d : {d1, d2, Vector3d(-d1), Vector3d(-d2)}) {
    const Vector3d p = rim.c + rim.r * d;
    const double depth = plane.under(p);
    if (depth <= 0) continue;
    // Deciding per piece instead of per point keeps all four points on one face; a mixed set would
    // give a wrong torque.
    // Where the piece's deepest point is in the prism, its overlap with the face decides; one that
    // goes by a corner has a large overlap with each face, and little of it is in the prism.
    const bool decided =
        rest.face == f && (rest.overlap < kResting ||
                           (rest.overlap < kMostDecided && depth > kDeepest * rest.overlap));
    if (!held_by_face(pair, f, decided, p, depth)) continue;
    if (held_by_pockets(pair, near, p, depth)) out.add(p, plane.n, depth);
  }
}

/// A rim on all faces through which its piece may leave, and on the pockets near it. False when it
/// is clear of the prism.
bool rim_on_prism(const Pair& pair, const Ring& ring, const Resting& rest, Candidates& out) {
  const RimS rim{pair.c + ring.z * pair.u, ring.r, pair.u, pair.e1, pair.e2,
                 pair.planes[kTop].sine};
  // The lowest point of a tilted circle is r sin(tilt) below its centre.
  if (rim.c.z() - rim.r * rim.sine >= pair.prism.z1) return false;
  const RimPockets near = pockets_of(rim, pair.pockets);
  if (near.free) return false;
  // A piece that only just overlaps with one face rests on that face alone.
  const bool one_face = rest.face >= 0 && rest.overlap < kResting;
  for (int f = 0; f < pair.plane_count; ++f) {
    if (!pair.planes[static_cast<std::size_t>(f)].exit || (one_face && rest.face != f)) continue;
    rim_on_face(pair, rim, f, rest, near, out);
  }
  for (int i = 0; i < near.count; ++i) {
    const PocketProfile& pocket = *near.touching[static_cast<std::size_t>(i)];
    rim_on_pocket_side(rim, pocket, pair.prism, out);
    if (!comes_from_below(pair)) rim_on_pocket_floor(rim, pocket, pair.prism.z0, out);
  }
  return true;
}

bool crossed(const Pair& pair, int plane) {
  return pair.planes[static_cast<std::size_t>(plane)].crossed;
}

/// Edges between two faces that the gear crosses both: of the top, of the bottom, along the prism.
void edges_on_gear(const Pair& pair, std::span<PieceContacts> pieces, Candidates& out,
                   Candidates& doubtful) {
  // Only edges whose both faces are crossed can be inside the gear.
  const Prism& prism = pair.prism;
  const auto normal = [&](int plane) -> const Vector3d& {
    return pair.planes[static_cast<std::size_t>(plane)].n;
  };
  for (int i = 0; i < prism.sides; ++i) {
    if (!crossed(pair, i + 2) || prism.internal[static_cast<std::size_t>(i)]) continue;
    const Eigen::Vector2d &a = prism.corner(i), &b = prism.corner(i + 1);
    const Vector3d a0(a.x(), a.y(), prism.z0), a1(a.x(), a.y(), prism.z1);
    const Vector3d b0(b.x(), b.y(), prism.z0), b1(b.x(), b.y(), prism.z1);
    const int next = (i + 1) % prism.sides, last = (i + prism.sides - 1) % prism.sides;
    const auto touch = [&](const Vector3d& from, const Vector3d& to, int other, int end_a,
                           int end_b) {
      if (!crossed(pair, other)) return;
      const StraightEdge edge{from, to, normal(i + 2), normal(other), normal(end_a), normal(end_b)};
      edge_on_gear(pair.gear, pair.X_SG, edge, pieces, out, doubtful);
    };
    touch(a1, b1, kTop, last + 2, next + 2);
    touch(a0, b0, kBottom, last + 2, next + 2);
    const bool joint = prism.internal[static_cast<std::size_t>(next)];
    if (!joint) touch(b0, b1, next + 2, kBottom, kTop);
  }
}

void edges_on_gear(const Pair& pair, const Polytope& polytope, std::span<PieceContacts> pieces,
                   Candidates& out, Candidates& doubtful) {
  for (const Polytope::Edge& edge : polytope.edges) {
    if (!crossed(pair, edge.left) || !crossed(pair, edge.right)) continue;
    const auto normal = [&polytope](int face) -> const Vector3d& { return polytope.face(face).n; };
    const StraightEdge straight{polytope.corner(edge.from), polytope.corner(edge.to),
                                normal(edge.left),          normal(edge.right),
                                normal(edge.before),        normal(edge.beyond)};
    edge_on_gear(pair.gear, pair.X_SG, straight, pieces, out, doubtful);
  }
}

/// Is p on the surface or inside, and not in a pocket?
bool in_material(const Pair& pair, const Vector3d& p) {
  constexpr double kSurface = 1e-9;
  for (int i = 0; i < pair.plane_count; ++i) {
    if (pair.planes[static_cast<std::size_t>(i)].under(p) < -kSurface) return false;
  }
  for (const PocketProfile& pocket : pair.pockets) {
    const double r = length(p.x() - pocket.x, p.y() - pocket.y);
    if (p.z() > -pocket.depth && pocket.behind_side(r, p.z()) < 0) return false;
  }
  return true;
}

/// For a gear so deep that none of its rims and none of the prism's edges lie near a surface: the
/// axis, where it passes through a face, holds it with the whole overlap.
void axis_on_prism(const Pair& pair, Candidates& out) {
  for (int f = 0; f < pair.plane_count; ++f) {
    const Plane& plane = pair.planes[static_cast<std::size_t>(f)];
    if (!plane.exit) continue;
    const double low = plane.under(pair.c + pair.gear.z_low * pair.u);
    const double high = plane.under(pair.c + pair.gear.z_high * pair.u);
    if ((low > 0) == (high > 0)) continue;
    // The signed distances at the axis' ends are linear along it, so that their ratio gives the
    // crossing.
    const double t = low / (low - high);
    const double z = pair.gear.z_low + t * (pair.gear.z_high - pair.gear.z_low);
    const Vector3d p = pair.c + z * pair.u;
    if (in_material(pair, p)) out.add(p, plane.n, std::max(low, high));
  }
}

/// How far the samples of a circle are out of the material, at least, by faces that the gear
/// crosses and by pockets.
APRSIM_VECTOR_CLONES void sample_outside(const Pair& pair, const CircleBasis& circle,
                                         CircleSamples& outside) {
  // A cheap lower bound per sample; the exact test follows for the few samples that it does not
  // exclude.
  const CircleSamples x = circle.samples(0), y = circle.samples(1), z = circle.samples(2);
  outside.fill(-1);
  for (int f = 0; f < pair.plane_count; ++f) {
    const Plane& plane = pair.planes[static_cast<std::size_t>(f)];
    if (!plane.crossed) continue;
    const double n_x = plane.n.x(), n_y = plane.n.y(), n_z = plane.n.z(), off = plane.off;
    for (std::size_t i = 0; i < kCircleSamples; ++i) {
      outside[i] = std::max(outside[i], n_x * x[i] + n_y * y[i] + n_z * z[i] - off);
    }
  }
  for (const PocketProfile& pocket : pair.pockets) {
    for (std::size_t i = 0; i < kCircleSamples; ++i) {
      const double dx = x[i] - pocket.x, dy = y[i] - pocket.y;
      const double before_side = -pocket.behind_side(std::sqrt(dx * dx + dy * dy), z[i]);
      outside[i] = std::max(outside[i], std::min(z[i] + pocket.depth, before_side));
    }
  }
}

/// Adds a point in the material with its nearest exit.
void add_nearest_exit(const Pair& pair, const Vector3d& p, Candidates& out) {
  const Plane* face = nullptr;
  for (int f = 0; f < pair.plane_count; ++f) {
    const Plane& plane = pair.planes[static_cast<std::size_t>(f)];
    if (plane.exit && (!face || plane.under(p) < face->under(p))) face = &plane;
  }
  if (!face) return;
  double least = face->under(p);
  const PocketProfile* into = nullptr;
  for (const PocketProfile& pocket : pair.pockets) {
    if (p.z() <= -pocket.depth && comes_from_below(pair)) continue;
    const double exit = exit_into_pocket(pocket, p);
    if (exit >= least) continue;
    least = exit;
    into = &pocket;
  }
  if (!into) return out.add(p, face->n, least);
  // Up from its floor. Its sides have been tested with the rims.
  if (p.z() <= -into->depth) out.add(p, Vector3d::UnitZ(), -into->depth - p.z());
}

/// The same for a rim that cuts right through: all its samples in the material.
void arcs_on_prism(const Pair& pair, const Ring& ring, Candidates& out) {
  constexpr double kSurely = 1e-8;  // [m]
  const CircleBasis circle{pair.c + ring.z * pair.u, ring.r * pair.e1, ring.r * pair.e2};
  CircleSamples outside;
  sample_outside(pair, circle, outside);
  for (int i = 0; i < kCircleSamples; ++i) {
    if (at_sample(outside, i) > kSurely) continue;
    const Vector3d p = circle.from_sample(i).at(0).p;
    if (in_material(pair, p)) add_nearest_exit(pair, p, out);
  }
}

/// After set_planes(). `add_edges` adds the contacts of the straight edges.
template <class AddEdges>
bool gear_on_planes(Pair& pair, const AddEdges& add_edges, Candidates& out) {
  const GearShape& gear = pair.gear;
  if (!classify_planes(pair)) return false;
  turn_to_pocket(pair);
  // Order: rims on faces and pockets, edges on pieces, then two fallbacks for penetrations so deep
  // that no feature of either body is near a surface.
  std::array<Resting, 4> rests;
  for (int i = 0; i < gear.piece_count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    rests[k] = resting(pair, gear.pieces[k]);
  }
  std::array<bool, 5> in_reach{};
  std::array<PieceContacts, 4> pieces;
  for (int i = 0; i < gear.ring_count; ++i) {
    const Ring& ring = gear.rings[static_cast<std::size_t>(i)];
    const Resting& rest = rests[static_cast<std::size_t>(ring.piece)];
    const int known = out.size();
    in_reach[static_cast<std::size_t>(i)] = !rest.apart && rim_on_prism(pair, ring, rest, out);
    if (out.size() > known) pieces[static_cast<std::size_t>(ring.piece)].held = true;
  }
  // Edges only where the gear reaches over one.
  if (pair.crossed_count > 1) {
    Candidates doubtful;
    add_edges(std::span<PieceContacts>(pieces), doubtful);
    // A peg whose end is just over an edge: the nearest exit that leads away from the prism.
    for (std::size_t k = 0; k < pieces.size(); ++k) {
      const auto& beside = pieces[k].beside;
      if (pieces[k].held || !beside || beside->depth > rests[k].overlap) continue;
      out.add(beside->p, beside->n, beside->depth);
    }
    if (out.size() == 0) out.add_all(doubtful);
  }
  if (out.size() == 0) axis_on_prism(pair, out);
  for (int i = 0, before = out.size(); i < gear.ring_count && before == 0; ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (in_reach[k]) arcs_on_prism(pair, gear.rings[k], out);
  }
  return true;
}

}  // namespace

bool gear_on_prism(const GearShape& gear, const Isometry3d& X_SG, const Prism& prism,
                   std::span<const PocketProfile> pockets, Candidates& out) {
  Pair pair(gear, X_SG, prism, pockets);
  set_planes(pair);
  const auto add_edges = [&](std::span<PieceContacts> pieces, Candidates& doubtful) {
    edges_on_gear(pair, pieces, out, doubtful);
  };
  return gear_on_planes(pair, add_edges, out);
}

bool gear_on_polytope(const GearShape& gear, const Isometry3d& X_SG, const Polytope& polytope,
                      Candidates& out) {
  Prism prism;  // only its middle and an unlimited height are used
  prism.middle = polytope.middle;
  prism.z0 = -1e30;
  prism.z1 = 1e30;
  Pair pair(gear, X_SG, prism, {});
  set_planes(pair, polytope);
  const auto add_edges = [&](std::span<PieceContacts> pieces, Candidates& doubtful) {
    edges_on_gear(pair, polytope, pieces, out, doubtful);
  };
  return gear_on_planes(pair, add_edges, out);
}

}  // namespace aprsim::physics::detail
