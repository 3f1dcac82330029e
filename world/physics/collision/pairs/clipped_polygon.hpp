#pragma once

#include <array>
#include <cstddef>

#include <Eigen/Core>

namespace aprsim::physics::detail {

/// A convex polygon being clipped by planes (Sutherland & Hodgman 1974): each cut adds at most one
/// corner.
template <std::size_t kCapacity>
struct ClippedPolygon {
  std::array<Eigen::Vector3d, kCapacity> v;
  std::size_t n = 0;

  void push(const Eigen::Vector3d& p) {
    if (n < v.size()) v[n++] = p;
  }
  /// Keeps the part where m . p <= off.
  void clip(const Eigen::Vector3d& m, double off) {
    ClippedPolygon out;
    for (std::size_t k = 0; k < n; ++k) {
      const Eigen::Vector3d &p = v[k], &q = v[(k + 1) % n];
      const double dp = m.dot(p) - off, dq = m.dot(q) - off;
      if (dp <= 0) out.push(p);
      if ((dp < 0 && dq > 0) || (dp > 0 && dq < 0)) out.push(p + (dp / (dp - dq)) * (q - p));
    }
    *this = out;
  }
};

}  // namespace aprsim::physics::detail
