#include <algorithm>
#include <cmath>

#include "world/physics/collision/pairs/narrow_phase.hpp"
#include "world/physics/collision/reduction/contact_reduction.hpp"

// Separating axes of oriented boxes (Gottschalk, Lin & Manocha 1996), then the contact manifold:
// the incident face clipped by the reference face (Sutherland & Hodgman 1974), or the points where
// two edges come closest (Ericson 2005, ch. 5.1.8).
namespace aprsim::physics {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Face normals win over edge directions, and box a over box b, unless the other is clearly
/// shallower: keeps the choice from flickering when boxes rest on each other.
constexpr double kEdgePreference = 0.95, kFacePreference = 0.98, kPreferenceSlack = 1e-7;
/// A face holds the boxes when it finds at least this share of the depth along its normal.
constexpr double kHeld = 0.8;
/// Edges more parallel than this (sine) have no contact of their own.
constexpr double kParallelSine = 1e-3;

struct Box {
  Vector3d half, centre;
  Matrix3d R;  ///< columns: axes in the working frame
};

/// The separating-axis search: the axis of least penetration.
struct Axis {
  enum class Kind { kFaceA, kFaceB, kEdges } kind = Kind::kFaceA;
  int i = 0, j = 0;  ///< face axis, or edge axes of a and b
  double depth = 1e30;
  Vector3d n = Vector3d::Zero();  ///< from b into a
};

/// Projection radius of an oriented box on a unit axis (Ericson 2005, ch. 4.4.1).
double reach(const Box& box, const Vector3d& n) {
  return box.half.dot((box.R.transpose() * n).cwiseAbs());
}

/// Depth along n (made to point from b to a); negative when the axis separates the boxes.
double overlap(const Box& a, const Box& b, Vector3d& n) {
  double d = n.dot(a.centre - b.centre);
  if (d < 0) {
    n = -n;
    d = -d;
  }
  return reach(a, n) + reach(b, n) - d;
}

/// The shallowest of the six face normals; false when one separates the boxes.
bool face_axes(const Box& a, const Box& b, Axis& best) {
  // A face axis must be clearly better to replace the one found so far. Otherwise rounding would
  // choose, and the manifold would change from step to step.
  for (const bool of_a : {true, false}) {
    for (int i = 0; i < 3; ++i) {
      Vector3d n = of_a ? a.R.col(i) : b.R.col(i);
      const double depth = overlap(a, b, n);
      if (depth <= 0) return false;
      const double limit = of_a == (best.kind == Axis::Kind::kFaceA)
                               ? best.depth
                               : kFacePreference * best.depth - kPreferenceSlack;
      if (depth < limit) {
        best = {of_a ? Axis::Kind::kFaceA : Axis::Kind::kFaceB, i, 0, depth, n};
      }
    }
  }
  return true;
}

/// The shallowest direction across two edges; false when one separates the boxes.
bool edge_axes(const Box& a, const Box& b, Axis& edge) {
  edge.kind = Axis::Kind::kEdges;
  // Cross products of nearly parallel edges have no direction; the face axes cover that case
  // (Ericson 2005, ch. 4.4.1).
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      Vector3d n = a.R.col(i).cross(b.R.col(j));
      const double sine = n.norm();
      if (sine < kParallelSine) continue;
      n /= sine;
      const double depth = overlap(a, b, n);
      if (depth <= 0) return false;
      if (depth < edge.depth) edge = {Axis::Kind::kEdges, i, j, depth, n};
    }
  }
  return true;
}

/// A convex polygon being clipped: a face has 4 corners and each of 4 cuts adds at most one.
struct Polygon {
  std::array<Vector3d, 8> v;
  int n = 0;
  void push(const Vector3d& p) { v[static_cast<std::size_t>(n++)] = p; }
};

/// The part of the polygon where m . p <= off.
Polygon clip(const Polygon& in, const Vector3d& m, double off) {
  Polygon out;
  for (int k = 0; k < in.n; ++k) {
    const Vector3d& p = in.v[static_cast<std::size_t>(k)];
    const Vector3d& q = in.v[static_cast<std::size_t>((k + 1) % in.n)];
    const double dp = m.dot(p) - off, dq = m.dot(q) - off;
    if (dp <= 0) out.push(p);
    if ((dp < 0 && dq > 0) || (dp > 0 && dq < 0)) out.push(p + (dp / (dp - dq)) * (q - p));
  }
  return out;
}

/// The face of `box` whose outward normal is most opposed to m.
Polygon opposing_face(const Box& box, const Vector3d& m) {
  const Vector3d local = box.R.transpose() * m;
  Eigen::Index k = 0;
  local.cwiseAbs().maxCoeff(&k);
  const Eigen::Index i = (k + 1) % 3, j = (k + 2) % 3;
  const Vector3d c = box.centre - std::copysign(box.half[k], local[k]) * box.R.col(k);
  const Vector3d u = box.half[i] * box.R.col(i), v = box.half[j] * box.R.col(j);
  Polygon face;
  face.push(c + u + v);
  face.push(c - u + v);
  face.push(c - u - v);
  face.push(c + u - v);
  return face;
}

/// Points of the incident box's face below the reference face. m: outward normal of that face.
void face_manifold(const Box& reference, int axis, const Vector3d& m, const Box& incident,
                   const Vector3d& n, detail::Candidates& out) {
  // Four clips against the side planes of the reference face leave the part of the incident face
  // above it.
  Polygon face = opposing_face(incident, m);
  for (int k = 1; k < 3; ++k) {
    const int side = (axis + k) % 3;
    const Vector3d s = reference.R.col(side);
    const double c = s.dot(reference.centre);
    face = clip(face, s, c + reference.half[side]);
    face = clip(face, -s, -c + reference.half[side]);
  }
  const double off = m.dot(reference.centre) + reference.half[axis];
  for (int k = 0; k < face.n; ++k) {
    const Vector3d& p = face.v[static_cast<std::size_t>(k)];
    out.add(p, n, off - m.dot(p));
  }
}

/// Middle of the shortest segment between the two edges.
void edge_contact(const Box& a, const Box& b, const Axis& axis, detail::Candidates& out) {
  const Vector3d na = a.R.transpose() * axis.n, nb = b.R.transpose() * axis.n;
  Vector3d pa = a.centre, pb = b.centre;
  for (int k = 0; k < 3; ++k) {
    if (k != axis.i) pa -= std::copysign(a.half[k], na[k]) * a.R.col(k);
    if (k != axis.j) pb += std::copysign(b.half[k], nb[k]) * b.R.col(k);
  }
  // Closest points of two lines p_a + s u and p_b + t v: both directions are orthogonal to the
  // connection.
  const Vector3d u = a.R.col(axis.i), v = b.R.col(axis.j), w = pb - pa;
  const double uv = u.dot(v), denominator = 1 - uv * uv;
  const double s = (u.dot(w) - uv * v.dot(w)) / denominator;
  const double t = (uv * u.dot(w) - v.dot(w)) / denominator;
  out.add(0.5 * (pa + s * u + pb + t * v), axis.n, axis.depth);
}

double deepest(const detail::Candidates& points) {
  double depth = 0;
  for (int i = 0; i < points.size(); ++i) depth = std::max(depth, points[i].depth);
  return depth;
}

}  // namespace

void box_box(const Vector3d& size_a, const Isometry3d& X_WA, const Vector3d& size_b,
             const Isometry3d& X_WB, BodyIndex a, BodyIndex b, SurfacePair pair,
             std::vector<Contact>& out) {
  // Bounding spheres first: most pairs from the broad phase end here.
  const double gap2 = (X_WA.translation() - X_WB.translation()).squaredNorm();
  const double radii = 0.5 * (size_a.norm() + size_b.norm());
  if (gap2 > radii * radii) return;
  const Box box_a{0.5 * size_a, X_WA.translation(), X_WA.linear()};
  const Box box_b{0.5 * size_b, X_WB.translation(), X_WB.linear()};
  // Separating axes: six face normals, nine cross products of edges.
  Axis face, edge;
  if (!face_axes(box_a, box_b, face) || !edge_axes(box_a, box_b, edge)) return;
  detail::Candidates points;
  if (edge.depth < kEdgePreference * face.depth - kPreferenceSlack) {
    edge_contact(box_a, box_b, edge, points);
  } else {
    const bool of_a = face.kind == Axis::Kind::kFaceA;
    const Box &reference = of_a ? box_a : box_b, &incident = of_a ? box_b : box_a;
    face_manifold(reference, face.i, of_a ? -face.n : face.n, incident, face.n, points);
    // Beside the reference face the deepest corner is clipped away: then the edges hold the boxes.
    const bool held = points.size() > 0 && deepest(points) > kHeld * face.depth;
    if (!held && edge.depth < face.depth / kHeld) edge_contact(box_a, box_b, edge, points);
  }
  static const Isometry3d kIdentity = Isometry3d::Identity();
  detail::emit_reduced(points, {kIdentity, a, b, pair, out});
}

}  // namespace aprsim::physics
