#include "world/physics/collision/pairs/cone_sides.hpp"

#include <algorithm>
#include <cmath>

namespace aprsim::physics::detail {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// The generator of a side whose outward normal is n: where it begins and its way to the other end.
struct Generator {
  Vector3d p, way;

  Generator(const Piece& piece, const Vector3d& c, const Vector3d& u, const Vector3d& n) {
    const Vector3d radial = (n - n.dot(u) * u).normalized();
    p = c + piece.z0 * u + piece.r0 * radial;
    way = (piece.z1 - piece.z0) * u + (piece.r1 - piece.r0) * radial;
  }
};

}  // namespace

void crossing_cones(const Piece& a, const Isometry3d& X_BA, const Piece& b, Candidates& out) {
  constexpr double kParallelAxes = 1e-3;  // sine
  constexpr double kDeepest = 0.5;        // of the narrower one's radius
  const Vector3d u = X_BA.linear().col(2), c = X_BA.translation(), z = Vector3d::UnitZ();
  const double cosine = u.z(), sine2 = 1 - cosine * cosine;
  if (sine2 < kParallelAxes * kParallelAxes) return;
  // The normals of a side make a circle on the unit sphere. Out of a and into b: where the circle
  // of a meets that of b, mirrored.
  const double along_a = -a.slope * a.cosine, along_b = b.slope * b.cosine;
  const double on_u = (along_a - cosine * along_b) / sine2;
  const double on_z = (along_b - cosine * along_a) / sine2;
  const double rest2 = 1 - on_u * along_a - on_z * along_b;
  if (rest2 <= 0) return;
  const double across = std::sqrt(rest2 / sine2);
  for (const double sign : {-1.0, 1.0}) {
    const Vector3d n = on_u * u + on_z * z + sign * across * u.cross(z);
    const Generator of_a(a, c, u, n), of_b(b, Vector3d::Zero(), z, -n);
    const double depth = n.dot(of_a.p - of_b.p);
    if (depth <= 0) continue;
    // Closest points of two lines (Ericson 2005, ch. 5.1.8).
    const Vector3d w = of_b.p - of_a.p;
    const double aa = of_a.way.squaredNorm(), bb = of_b.way.squaredNorm();
    const double ab = of_a.way.dot(of_b.way), wa = w.dot(of_a.way), wb = w.dot(of_b.way);
    const double denominator = aa * bb - ab * ab;
    if (denominator < kParallelAxes * kParallelAxes * aa * bb) continue;
    const double s = (wa * bb - wb * ab) / denominator, t = (wa * ab - wb * aa) / denominator;
    if (s < 0 || s > 1 || t < 0 || t > 1) continue;
    const double narrow = std::min(a.r0 + s * (a.r1 - a.r0), b.r0 + t * (b.r1 - b.r0));
    if (depth > kDeepest * narrow) continue;
    out.add(0.5 * (of_a.p + s * of_a.way + of_b.p + t * of_b.way), -n, depth);
  }
}

}  // namespace aprsim::physics::detail
