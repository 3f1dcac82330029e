#include "world/physics/collision/shapes/polytope.hpp"

namespace aprsim::physics::detail {

using Eigen::Vector3d;

void Polytope::set_prism(const Prism& prism) {
  const int n = prism.sides;
  corners.clear();
  faces.clear();
  edges.clear();
  loops.clear();
  middle = prism.middle;
  // Corner i is below corner n + i.
  for (const double z : {prism.z0, prism.z1}) {
    for (int i = 0; i < n; ++i) corners.emplace_back(prism.corner(i).x(), prism.corner(i).y(), z);
  }
  const auto first = [this] { return static_cast<int>(loops.size()); };
  for (int i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const int next = (i + 1) % n;
    faces.push_back(
        {{prism.n[k].x(), prism.n[k].y(), 0}, prism.off[k], first(), 4, prism.internal[k]});
    for (const int corner : {i, next, n + next, n + i}) loops.push_back(corner);
  }
  faces.push_back({-Vector3d::UnitZ(), -prism.z0, first(), n, false});
  for (int i = n - 1; i >= 0; --i) loops.push_back(i);
  faces.push_back({Vector3d::UnitZ(), prism.z1, first(), n, false});
  for (int i = 0; i < n; ++i) loops.push_back(n + i);
  for (int i = 0; i < n; ++i) {
    const int next = (i + 1) % n, last = (i + n - 1) % n;
    edges.push_back({i, next, i, n, last, next});
    edges.push_back({n + i, n + next, n + 1, i, last, next});
    edges.push_back({i, n + i, last, i, n, n + 1});
  }
}

void Polytope::set_hull(const api::HullPiece& hull) {
  *this = {};
  corners = hull.corners;
  for (const Vector3d& corner : corners) middle += corner;
  middle /= static_cast<double>(corners.size());
  for (const auto& loop : hull.faces) {
    Face face;
    face.first = static_cast<int>(loops.size());
    face.count = static_cast<int>(loop.size());
    loops.insert(loops.end(), loop.begin(), loop.end());
    // Newell's method: the mean normal over all corners.
    face.n.setZero();
    for (int k = 0; k < face.count; ++k) {
      face.n += corner(loop_corner(face, k)).cross(corner(loop_corner(face, k + 1)));
    }
    face.n.normalize();
    for (int k = 0; k < face.count; ++k) {
      face.off += face.n.dot(corner(loop_corner(face, k))) / face.count;
    }
    faces.push_back(face);
  }
  // Each edge once, from its face to the left; its twin runs the other way around the right one.
  for (int f = 0; f < static_cast<int>(faces.size()); ++f) {
    for (int k = 0; k < face(f).count; ++k) {
      const int from = loop_corner(face(f), k), to = loop_corner(face(f), k + 1);
      for (int g = f + 1; g < static_cast<int>(faces.size()); ++g) {
        for (int m = 0; m < face(g).count; ++m) {
          if (loop_corner(face(g), m) == to && loop_corner(face(g), m + 1) == from) {
            edges.push_back({from, to, f, g});
          }
        }
      }
    }
  }
  for (Edge& edge : edges) {
    edge.before = third_face(edge.from, edge);
    edge.beyond = third_face(edge.to, edge);
  }
}

int Polytope::third_face(int corner, const Edge& edge) const {
  for (int f = 0; f < static_cast<int>(faces.size()); ++f) {
    if (f == edge.left || f == edge.right) continue;
    for (int k = 0; k < face(f).count; ++k) {
      if (loop_corner(face(f), k) == corner) return f;
    }
  }
  return edge.left;
}

}  // namespace aprsim::physics::detail
