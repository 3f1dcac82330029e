#include <algorithm>
#include <array>
#include <cmath>

#include "world/physics/collision/pairs/clipped_polygon.hpp"
#include "world/physics/collision/pairs/narrow_phase.hpp"
#include "world/physics/collision/reduction/contact_reduction.hpp"

// Convex prisms against each other, by the method of box_box.cpp: separating axes, then the
// incident face clipped by the reference face, or the points where two edges come closest. Edges of
// a prism are those around its two ends and those along it.
namespace aprsim::physics::prisms {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// As in box_box.cpp: preferences between faces and edges, which keep the choice steady.
constexpr double kEdgePreference = 0.95, kFacePreference = 0.98, kPreferenceSlack = 1e-7;
constexpr double kHeld = 0.8;
constexpr double kParallelSine = 1e-3;
/// An edge holds the prism up along a direction if it lies so near to its support plane [m].
constexpr double kSupport = 1e-7;

constexpr std::size_t kMaxSides = scene::Outline::kMaxCorners;
constexpr int kTop = 0, kBottom = 1, kFirstSide = 2;

/// A prism in the world.
class Hull {
 public:
  Hull(const SlabShape& slab, const Isometry3d& X_WS)
      : X_WS_(X_WS), height_(slab.size.z()), up_(X_WS.linear().col(2)) {
    const Vector2d half = 0.5 * slab.size.head<2>();
    if (slab.outline) {
      for (std::size_t i = 0; i < slab.outline->corners.size(); ++i) {
        add_side(slab.outline->corners[i] - slab.middle, slab.outline->normals[i]);
      }
    } else {
      add_side({-half.x(), -half.y()}, {0, -1});
      add_side({half.x(), -half.y()}, {1, 0});
      add_side({half.x(), half.y()}, {0, 1});
      add_side({-half.x(), half.y()}, {-1, 0});
    }
  }

  [[nodiscard]] std::size_t sides() const { return sides_; }
  [[nodiscard]] int faces() const { return static_cast<int>(sides_) + kFirstSide; }
  [[nodiscard]] const Vector3d& up() const { return up_; }
  [[nodiscard]] const Vector3d& low(std::size_t i) const { return low_[i % sides_]; }
  [[nodiscard]] Vector3d high(std::size_t i) const { return low(i) + height_ * up_; }
  /// Along side i, of unit length.
  [[nodiscard]] Vector3d along(std::size_t i) const { return up_.cross(normals_[i % sides_]); }
  /// Outward normal of a face.
  [[nodiscard]] Vector3d normal(int face) const {
    if (face == kTop) return up_;
    return face == kBottom ? Vector3d(-up_) : normals_[static_cast<std::size_t>(face - kFirstSide)];
  }
  /// A point of a face.
  [[nodiscard]] Vector3d on_face(int face) const {
    if (face == kTop) return high(0);
    return low(face == kBottom ? 0 : static_cast<std::size_t>(face - kFirstSide));
  }
  /// Largest n . p over the prism.
  [[nodiscard]] double support(const Vector3d& n) const {
    double most = n.dot(low_[0]);
    for (std::size_t i = 1; i < sides_; ++i) most = std::max(most, n.dot(low_[i]));
    return most + std::max(0.0, height_ * n.dot(up_));
  }
  /// The corner of the lower end that lies farthest along n.
  [[nodiscard]] std::size_t farthest(const Vector3d& n) const {
    std::size_t best = 0;
    for (std::size_t i = 1; i < sides_; ++i) {
      if (n.dot(low_[i]) > n.dot(low_[best])) best = i;
    }
    return best;
  }
  /// The face whose outward normal is most opposed to m.
  [[nodiscard]] int opposing_face(const Vector3d& m) const {
    int best = kTop;
    for (int face = kBottom; face < faces(); ++face) {
      if (m.dot(normal(face)) < m.dot(normal(best))) best = face;
    }
    return best;
  }

 private:
  void add_side(const Vector2d& corner, const Vector2d& normal) {
    low_[sides_] = X_WS_ * Vector3d(corner.x(), corner.y(), -0.5 * height_);
    normals_[sides_] = X_WS_.linear() * Vector3d(normal.x(), normal.y(), 0);
    ++sides_;
  }

  const Isometry3d& X_WS_;
  double height_;
  Vector3d up_;
  std::size_t sides_ = 0;
  std::array<Vector3d, kMaxSides> low_, normals_;
};

/// The axis of least penetration.
struct Axis {
  bool of_a = true;  ///< the face is a's
  int face = kTop;
  double depth = 1e30;
  Vector3d n = Vector3d::Zero();  ///< from b into a
  // Edges: any points of them and their directions.
  Vector3d p_a, d_a, p_b, d_b;
};

/// How far a must move along n to leave b; negative when n separates them.
double overlap(const Hull& a, const Hull& b, const Vector3d& n) {
  return b.support(n) + a.support(-n);
}

/// The shallowest face normal; false when one separates the prisms.
bool face_axes(const Hull& a, const Hull& b, Axis& best) {
  for (const bool of_a : {true, false}) {
    const Hull& own = of_a ? a : b;
    for (int face = 0; face < own.faces(); ++face) {
      const Vector3d n = of_a ? Vector3d(-own.normal(face)) : own.normal(face);
      const double depth = overlap(a, b, n);
      if (depth <= 0) return false;
      // A face must be clearly better to replace one of the other prism.
      const double limit =
          of_a == best.of_a ? best.depth : kFacePreference * best.depth - kPreferenceSlack;
      if (depth >= limit) continue;
      best.of_a = of_a;
      best.face = face;
      best.depth = depth;
      best.n = n;
    }
  }
  return true;
}

/// A point of the edge with direction number k (sides, then along the prism) that supports the hull
/// along m; false if that edge is not where it is supported.
bool supporting_edge(const Hull& hull, std::size_t k, const Vector3d& m, Vector3d& p) {
  const bool upper = m.dot(hull.up()) > 0;
  const std::size_t corner = k < hull.sides() ? k : hull.farthest(m);
  p = k < hull.sides() && upper ? hull.high(corner) : hull.low(corner);
  return m.dot(p) > hull.support(m) - kSupport;
}

/// The shallowest direction across two edges; false when one separates the prisms.
bool edge_axes(const Hull& a, const Hull& b, Axis& edge) {
  const auto direction = [](const Hull& hull, std::size_t k) {
    return k < hull.sides() ? hull.along(k) : hull.up();
  };
  for (std::size_t i = 0; i <= a.sides(); ++i) {
    const Vector3d d_a = direction(a, i);
    for (std::size_t j = 0; j <= b.sides(); ++j) {
      const Vector3d d_b = direction(b, j);
      const Vector3d across = d_a.cross(d_b);
      const double sine = across.norm();
      if (sine < kParallelSine) continue;
      for (const double sign : {1.0, -1.0}) {
        const Vector3d n = sign / sine * across;
        const double depth = overlap(a, b, n);
        if (depth <= 0) return false;
        if (depth >= edge.depth) continue;
        Vector3d p_a, p_b;
        if (!supporting_edge(a, i, -n, p_a) || !supporting_edge(b, j, n, p_b)) continue;
        edge.depth = depth;
        edge.n = n;
        edge.p_a = p_a;
        edge.d_a = d_a;
        edge.p_b = p_b;
        edge.d_b = d_b;
      }
    }
  }
  return true;
}

using Polygon = detail::ClippedPolygon<2 * kMaxSides>;

Polygon polygon_of(const Hull& hull, int face) {
  Polygon polygon;
  if (face == kTop || face == kBottom) {
    for (std::size_t i = 0; i < hull.sides(); ++i) {
      polygon.push(face == kTop ? hull.high(i) : hull.low(i));
    }
    return polygon;
  }
  const auto side = static_cast<std::size_t>(face - kFirstSide);
  polygon.push(hull.low(side));
  polygon.push(hull.low(side + 1));
  polygon.push(hull.high(side + 1));
  polygon.push(hull.high(side));
  return polygon;
}

/// Cuts off what lies beside a face.
void clip_beside(Polygon& polygon, const Hull& hull, int face) {
  if (face == kTop || face == kBottom) {
    for (int k = kFirstSide; k < hull.faces(); ++k) {
      polygon.clip(hull.normal(k), hull.normal(k).dot(hull.on_face(k)));
    }
    return;
  }
  const auto side = static_cast<std::size_t>(face - kFirstSide);
  const Vector3d along = hull.along(side);
  polygon.clip(along, along.dot(hull.low(side + 1)));
  polygon.clip(-along, -along.dot(hull.low(side)));
  for (const int end : {kTop, kBottom}) {
    polygon.clip(hull.normal(end), hull.normal(end).dot(hull.on_face(end)));
  }
}

/// Points of the incident prism's face below the reference face.
void face_manifold(const Hull& reference, const Hull& incident, const Axis& axis,
                   detail::Candidates& out) {
  const Vector3d m = reference.normal(axis.face);
  Polygon polygon = polygon_of(incident, incident.opposing_face(m));
  clip_beside(polygon, reference, axis.face);
  const double off = m.dot(reference.on_face(axis.face));
  for (std::size_t k = 0; k < polygon.n; ++k) {
    out.add(polygon.v[k], axis.n, off - m.dot(polygon.v[k]));
  }
}

/// Middle of the shortest segment between the two edges.
void edge_contact(const Axis& edge, detail::Candidates& out) {
  const Vector3d w = edge.p_b - edge.p_a;
  const double uv = edge.d_a.dot(edge.d_b), denominator = 1 - uv * uv;
  const double s = (edge.d_a.dot(w) - uv * edge.d_b.dot(w)) / denominator;
  const double t = (uv * edge.d_a.dot(w) - edge.d_b.dot(w)) / denominator;
  out.add(0.5 * (edge.p_a + s * edge.d_a + edge.p_b + t * edge.d_b), edge.n, edge.depth);
}

double deepest(const detail::Candidates& points) {
  double depth = 0;
  for (int i = 0; i < points.size(); ++i) depth = std::max(depth, points[i].depth);
  return depth;
}

}  // namespace
}  // namespace aprsim::physics::prisms

namespace aprsim::physics {

using Eigen::Isometry3d;

void slab_slab(const SlabShape& slab_a, const Isometry3d& X_WA, const SlabShape& slab_b,
               const Isometry3d& X_WB, BodyIndex a, BodyIndex b, SurfacePair pair,
               std::vector<Contact>& out) {
  if (!slab_a.outline && !slab_b.outline) {
    box_box(slab_a.size, X_WA, slab_b.size, X_WB, a, b, pair, out);
    return;
  }
  const double gap2 = (X_WA.translation() - X_WB.translation()).squaredNorm();
  const double radii = 0.5 * (slab_a.size.norm() + slab_b.size.norm());
  if (gap2 > radii * radii) return;
  const prisms::Hull hull_a(slab_a, X_WA), hull_b(slab_b, X_WB);
  prisms::Axis face, edge;
  if (!prisms::face_axes(hull_a, hull_b, face) || !prisms::edge_axes(hull_a, hull_b, edge)) return;
  detail::Candidates points;
  if (edge.depth < prisms::kEdgePreference * face.depth - prisms::kPreferenceSlack) {
    prisms::edge_contact(edge, points);
  } else {
    const prisms::Hull &reference = face.of_a ? hull_a : hull_b,
                       &incident = face.of_a ? hull_b : hull_a;
    prisms::face_manifold(reference, incident, face, points);
    // Beside the reference face the deepest corner is clipped away: then the edges hold the prisms.
    const bool held = points.size() > 0 && prisms::deepest(points) > prisms::kHeld * face.depth;
    if (!held && edge.depth < face.depth / prisms::kHeld) prisms::edge_contact(edge, points);
  }
  static const Isometry3d kIdentity = Isometry3d::Identity();
  detail::emit_reduced(points, {kIdentity, a, b, pair, out, false, true});
}

}  // namespace aprsim::physics
