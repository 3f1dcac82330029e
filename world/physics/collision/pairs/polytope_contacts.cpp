#include "world/physics/collision/pairs/polytope_contacts.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "world/physics/collision/pairs/clipped_polygon.hpp"

// Separating axes of convex polyhedra (Gregorius, "The Separating Axis Test between Convex
// Polyhedra", GDC 2013): the normals of all faces, and across those pairs of edges whose arcs meet
// on the Gauss map, since only these are faces of the Minkowski difference. Then, as in
// box_box.cpp, the incident face is clipped by the reference face.
namespace aprsim::physics::detail {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// Preferences between faces and edges, which keep the choice steady; as in slab_slab.cpp.
constexpr double kEdgeOverFace = 0.95, kOtherFace = 0.98, kChoiceSlack = 1e-7;
constexpr double kHeldShare = 0.8;
constexpr double kParallel = 1e-3;  // sine between edges

/// A polyhedron in the common frame.
struct Placed {
  const Polytope& polytope;
  std::array<Vector3d, Polytope::kMaxCorners> corners;
  std::array<Vector3d, Polytope::kMaxFaces> normals;
  Vector3d middle;

  Placed(const Polytope& own, const Isometry3d& X) : polytope(own), middle(X * own.middle) {
    for (std::size_t i = 0; i < own.corners.size(); ++i) corners[i] = X * own.corners[i];
    for (std::size_t i = 0; i < own.faces.size(); ++i) normals[i] = X.linear() * own.faces[i].n;
  }
  [[nodiscard]] const Vector3d& corner(int i) const { return corners[static_cast<std::size_t>(i)]; }
  [[nodiscard]] const Vector3d& normal(int i) const { return normals[static_cast<std::size_t>(i)]; }
  /// n . p on a face.
  [[nodiscard]] double off(int face) const {
    return normal(face).dot(corner(polytope.loop_corner(polytope.face(face), 0)));
  }
  /// Least n . p over the corners.
  [[nodiscard]] double lowest(const Vector3d& n) const {
    double least = n.dot(corners[0]);
    for (std::size_t i = 1; i < polytope.corners.size(); ++i) {
      least = std::min(least, n.dot(corners[i]));
    }
    return least;
  }
};

struct LeastAxis {
  bool of_a = true;  ///< the face is a's
  int face = -1;
  double depth = 1e30;
  Vector3d n = Vector3d::Zero();  ///< from b into a
  Vector3d p = Vector3d::Zero();  ///< of two edges: middle between them
};

/// The shallowest face; false where one separates the two.
bool least_face(const Placed& a, const Placed& b, LeastAxis& best) {
  for (const bool of_a : {true, false}) {
    const Placed &own = of_a ? a : b, &other = of_a ? b : a;
    for (int f = 0; f < static_cast<int>(own.polytope.faces.size()); ++f) {
      const double depth = own.off(f) - other.lowest(own.normal(f));
      if (depth <= 0) return false;
      if (own.polytope.face(f).internal) continue;
      // A face must be clearly better to replace one of the other body.
      const double limit = of_a == best.of_a ? best.depth : kOtherFace * best.depth - kChoiceSlack;
      if (depth >= limit) continue;
      best.of_a = of_a;
      best.face = f;
      best.depth = depth;
      best.n = of_a ? Vector3d(-own.normal(f)) : own.normal(f);
    }
  }
  return true;
}

/// Whether the arcs of two edges between their faces' normals cross; c and d belong to the second
/// body, mirrored.
bool arcs_cross(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
  const Vector3d b_x_a = b.cross(a), d_x_c = d.cross(c);
  const double cba = c.dot(b_x_a), dba = d.dot(b_x_a), adc = a.dot(d_x_c), bdc = b.dot(d_x_c);
  return cba * dba < 0 && adc * bdc < 0 && cba * bdc > 0;
}

/// Middle of the shortest line between two edges.
Vector3d between(const Vector3d& p_a, const Vector3d& d_a, const Vector3d& p_b,
                 const Vector3d& d_b) {
  const Vector3d w = p_b - p_a;
  const double uv = d_a.dot(d_b), denominator = 1 - uv * uv;
  const double s = (d_a.dot(w) - uv * d_b.dot(w)) / denominator;
  const double t = (uv * d_a.dot(w) - d_b.dot(w)) / denominator;
  return 0.5 * (p_a + s * d_a + p_b + t * d_b);
}

/// The shallowest direction across two edges; false where one separates the two.
bool least_edges(const Placed& a, const Placed& b, LeastAxis& best) {
  for (const Polytope::Edge& e : a.polytope.edges) {
    if (a.polytope.face(e.left).internal || a.polytope.face(e.right).internal) continue;
    const Vector3d &p_a = a.corner(e.from), d_a = (a.corner(e.to) - p_a).normalized();
    const Vector3d &left = a.normal(e.left), &right = a.normal(e.right);
    for (const Polytope::Edge& g : b.polytope.edges) {
      if (b.polytope.face(g.left).internal || b.polytope.face(g.right).internal) continue;
      if (!arcs_cross(left, right, -b.normal(g.left), -b.normal(g.right))) continue;
      const Vector3d &p_b = b.corner(g.from), d_b = (b.corner(g.to) - p_b).normalized();
      Vector3d n = d_a.cross(d_b);
      const double sine = n.norm();
      if (sine < kParallel) continue;
      n /= sine;
      if (n.dot(p_a - a.middle) < 0) n = -n;  // out of a
      const double depth = n.dot(p_a - p_b);
      if (depth <= 0) return false;
      if (depth >= best.depth) continue;
      best.face = 0;
      best.depth = depth;
      best.n = -n;
      best.p = between(p_a, d_a, p_b, d_b);
    }
  }
  return true;
}

using CutPolygon = detail::ClippedPolygon<2 * Polytope::kMaxCorners>;

/// Corners of the incident face below the reference face.
void clipped_face(const Placed& reference, const Placed& incident, const LeastAxis& axis,
                  Candidates& out) {
  const Vector3d& m = reference.normal(axis.face);
  int opposite = 0;
  for (int f = 1; f < static_cast<int>(incident.polytope.faces.size()); ++f) {
    if (m.dot(incident.normal(f)) < m.dot(incident.normal(opposite))) opposite = f;
  }
  CutPolygon polygon;
  const Polytope::Face& face = incident.polytope.face(opposite);
  for (int k = 0; k < face.count; ++k) {
    polygon.push(incident.corner(incident.polytope.loop_corner(face, k)));
  }
  const Polytope::Face& own = reference.polytope.face(axis.face);
  for (int k = 0; k < own.count; ++k) {
    const Vector3d& p = reference.corner(reference.polytope.loop_corner(own, k));
    const Vector3d& q = reference.corner(reference.polytope.loop_corner(own, k + 1));
    const Vector3d beside = (q - p).cross(m).normalized();
    polygon.clip(beside, beside.dot(p));
  }
  const double off = reference.off(axis.face);
  for (std::size_t k = 0; k < polygon.n; ++k) {
    out.add(polygon.v[k], axis.n, off - m.dot(polygon.v[k]));
  }
}

/// The incident body's corner farthest below the reference face.
Vector3d lowest_corner(const Placed& incident, const LeastAxis& face) {
  const Vector3d m = face.of_a ? Vector3d(-face.n) : face.n;
  const auto begin = incident.corners.begin();
  return *std::min_element(begin,
                           begin + static_cast<std::ptrdiff_t>(incident.polytope.corners.size()),
                           [&m](const auto& p, const auto& q) { return m.dot(p) < m.dot(q); });
}

}  // namespace

void polytope_on_polytope(const Polytope& polytope_a, const Isometry3d& X_BA,
                          const Polytope& polytope_b, Candidates& out) {
  const Placed a(polytope_a, X_BA), b(polytope_b, Isometry3d::Identity());
  LeastAxis face, edge;
  if (!least_face(a, b, face) || !least_edges(a, b, edge)) return;
  if (edge.depth < kEdgeOverFace * face.depth - kChoiceSlack)
    return out.add(edge.p, edge.n, edge.depth);
  if (face.face < 0) return;
  Candidates points;
  clipped_face(face.of_a ? a : b, face.of_a ? b : a, face, points);
  out.add_all(points);
  double deepest = 0;
  for (int i = 0; i < points.size(); ++i) deepest = std::max(deepest, points[i].depth);
  // Beside the reference face the deepest corner is clipped away: then the edges hold the bodies.
  const bool held = deepest > kHeldShare * face.depth;
  if (!held && edge.depth < face.depth / kHeldShare) {
    out.add(edge.p, edge.n, edge.depth);
  } else if (points.size() == 0) {
    // Edges that are nearly parallel: the corner farthest below the face, which is beside it.
    out.add(lowest_corner(face.of_a ? b : a, face), face.n, face.depth);
  }
}

}  // namespace aprsim::physics::detail
