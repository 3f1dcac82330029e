#include "world/physics/simplification/contact_wrench_cone.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/QR>

namespace aprsim::physics {
namespace {

using Eigen::Vector3d;

constexpr double kSameNormal = 1 - 1e-6;
/// Slack of every comparison, so that rounding breaks nothing: far below the 1 % of onset.
constexpr double kSlack = 1e-9;

/// Any unit vector across n.
Vector3d across(const Vector3d& n) {
  const Vector3d axis = std::abs(n.z()) < 0.7 ? Vector3d::UnitZ() : Vector3d::UnitX();
  return n.cross(axis).normalized();
}

/// Non-negative least squares, min |G x - w| for x >= 0, by Lawson & Hanson (Solving Least Squares
/// Problems, 1974, ch. 23), with six rows: whether the minimum is zero, that is, whether w lies in
/// the cone that G's columns span. Deviation: at most six columns are active.
/// Normalised columns make the tolerance relative to the wrench, whatever the units of force and
/// moment.
class ConeTest {
 public:
  static constexpr int kColumns = 9 * ContactWrenchCone::kMaxPoints;
  using Vector6 = Eigen::Matrix<double, 6, 1>;

  void add(const Vector6& column) { columns_.col(count_++) = column / column.norm(); }
  bool holds(const Vector6& w) {
    const double scale = w.norm();
    Vector6 rest = w;  // residual w - G x
    for (int round = 0; round < kRounds; ++round) {
      if (rest.norm() <= kTolerance * scale) return true;
      const int best = steepest(rest);
      if (best < 0) return false;
      active_[static_cast<std::size_t>(size_)] = best;
      x_[static_cast<std::size_t>(size_++)] = 0;
      descend(w);
      rest = w;
      for (int k = 0; k < size_; ++k) rest -= x(k) * columns_.col(at(k));
    }
    return rest.norm() <= kTolerance * scale;
  }

 private:
  static constexpr int kRounds = 60;
  static constexpr double kTolerance = 1e-9;
  using Matrix = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::ColMajor, 6, 7>;
  using Solution = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 7, 1>;

  [[nodiscard]] int at(int k) const { return active_[static_cast<std::size_t>(k)]; }
  [[nodiscard]] double& x(int k) { return x_[static_cast<std::size_t>(k)]; }

  /// The idle column along which the residual falls fastest; -1: none, w lies outside.
  [[nodiscard]] int steepest(const Vector6& rest) const {
    if (size_ >= 6) return -1;
    int best = -1;
    double most = kTolerance * rest.norm();
    for (int i = 0; i < count_; ++i) {
      if (std::find(active_.begin(), active_.begin() + size_, i) != active_.begin() + size_) {
        continue;
      }
      // The gradient of 1/2 |G x - w|^2 by an idle x_i is -gain: only positive gains may enter.
      const double gain = columns_.col(i).dot(rest);
      if (gain > most) {
        most = gain;
        best = i;
      }
    }
    return best;
  }

  /// Least squares over the active columns; those that would turn negative leave.
  void descend(const Vector6& w) {
    while (size_ > 0) {
      Matrix G(6, size_);
      for (int k = 0; k < size_; ++k) G.col(k) = columns_.col(at(k));
      // Unconstrained least squares over the active set. Where it leaves the positive orthant, the
      // step ends at its boundary (Lawson & Hanson, algorithm NNLS, steps 6 to 11).
      const Solution z = G.colPivHouseholderQr().solve(w);
      double step = 1;
      for (int k = 0; k < size_; ++k) {
        if (z[k] <= 0) step = std::min(step, x(k) / (x(k) - z[k]));
      }
      for (int k = 0; k < size_; ++k) x(k) += step * (z[k] - x(k));
      if (step >= 1) return;
      int kept = 0;
      for (int k = 0; k < size_; ++k) {
        if (x(k) <= 1e-14 * w.norm() && z[k] <= 0) continue;
        active_[static_cast<std::size_t>(kept)] = at(k);
        x_[static_cast<std::size_t>(kept++)] = x(k);
      }
      if (kept == size_) return;
      size_ = kept;
    }
  }

  Eigen::Matrix<double, 6, kColumns> columns_;
  int count_ = 0, size_ = 0;
  std::array<int, 8> active_{};
  std::array<double, 8> x_{};
};

}  // namespace

void ContactWrenchCone::add(const Vector3d& p, const Vector3d& n, double friction) {
  if (count_ < kMaxPoints) points_[static_cast<std::size_t>(count_++)] = {p, n, friction};
}

/// The largest set of points with one normal, sorted into a polygon.
void ContactWrenchCone::finish() {
  // The polygon test needs coplanar points with one normal. Points with other normals are left to
  // the exact test.
  corners_ = 0;
  for (int i = 0; i < count_; ++i) {
    const Vector3d n = points_[static_cast<std::size_t>(i)].n;
    std::array<Vector3d, kMaxPoints> same;
    int number = 0;
    double friction = 1e30;
    for (int k = 0; k < count_; ++k) {
      const Point& point = points_[static_cast<std::size_t>(k)];
      if (point.n.dot(n) < kSameNormal) continue;
      same[static_cast<std::size_t>(number++)] = point.p;
      friction = std::min(friction, point.friction);
    }
    if (number <= corners_) continue;
    corners_ = number;
    corner_ = same;
    normal_ = n;
    friction_ = friction;
  }
  if (corners_ == 0) return;
  centre_.setZero();
  for (int k = 0; k < corners_; ++k) centre_ += corner_[static_cast<std::size_t>(k)] / corners_;
  extent_ = 0;
  for (int i = 0; i < count_; ++i) {
    extent_ = std::max(extent_, (points_[static_cast<std::size_t>(i)].p - centre_).norm());
  }
  extent_ = std::max(extent_, 1e-3);
  const Vector3d u = across(normal_), v = normal_.cross(u);
  const auto angle = [&](const Vector3d& p) {
    return std::atan2(v.dot(p - centre_), u.dot(p - centre_));
  };
  // Counter-clockwise around the centre, as the point-in-polygon test requires.
  std::sort(corner_.begin(), corner_.begin() + corners_,
            [&](const Vector3d& a, const Vector3d& b) { return angle(a) < angle(b); });
}

bool ContactWrenchCone::contains(const Wrench& wrench) const {
  if (count_ == 0) return wrench.force.isZero() && wrench.moment.isZero();
  return polygon_contains(wrench) || cones_contain(wrench);
}

/// Sufficient, and cheap: the centre of pressure lies in the polygon of the points, and friction
/// splits into sliding in proportion to the pressure and spin about its centre; both together bound
/// the load of the worst point.
bool ContactWrenchCone::polygon_contains(const Wrench& wrench) const {
  if (corners_ < 3) return false;
  const double pressure = wrench.force.dot(normal_);
  if (!(pressure > 0)) return false;
  const Vector3d moment = wrench.moment - centre_.cross(wrench.force);
  // Centre of pressure: the point of the plane about which the wrench has no moment across the
  // normal.
  const Vector3d cop = normal_.cross(moment) / pressure;  // from the centre
  double nearest2 = 1e30, farthest2 = 0;
  for (int k = 0; k < corners_; ++k) {
    const Vector3d a = corner_[static_cast<std::size_t>(k)] - centre_;
    const Vector3d b = corner_[static_cast<std::size_t>((k + 1) % corners_)] - centre_;
    if (normal_.dot((b - a).cross(cop - a)) < -kSlack * extent_ * extent_) return false;
    nearest2 = std::min(nearest2, (a - cop).squaredNorm());
    farthest2 = std::max(farthest2, (a - cop).squaredNorm());
  }
  // Sufficient condition, in the manner of a limit surface (Goyal, Ruina & Papadopoulos 1991):
  // friction for sliding and for spin must fit together within mu times the pressure at the worst
  // point.
  const double sliding = (wrench.force - pressure * normal_).norm();
  const double spin = std::abs((moment - cop.cross(wrench.force)).dot(normal_));
  const double limit = friction_ * pressure * (1 + kSlack);
  if (spin <= kSlack * extent_ * pressure) return sliding <= limit;
  return sliding * nearest2 + spin * std::sqrt(farthest2) <= limit * nearest2;
}

/// Exact but for the cones' edges: whether forces within the friction cones of all points add up to
/// the wrench. Each cone is spanned by its axis and eight edges, one of them along the sliding
/// force, so that plain sliding is exact.
bool ContactWrenchCone::cones_contain(const Wrench& wrench) const {
  constexpr int kEdges = 8;
  constexpr double kTurn = 0.78539816339744831;  // 2 pi / kEdges
  ConeTest test;
  const auto column = [&](const Vector3d& p, const Vector3d& f) {
    ConeTest::Vector6 c;
    c << f, (p - centre_).cross(f) / extent_;
    test.add(c);
  };
  for (int i = 0; i < count_; ++i) {
    const Point& point = points_[static_cast<std::size_t>(i)];
    Vector3d u = wrench.force - wrench.force.dot(point.n) * point.n;
    // Aligning one edge with the tangential force makes the inscribed octagon exact in that
    // direction. The other directions lose at most 1 - cos(pi / 8), about 8 %.
    u = u.norm() > 1e-9 * wrench.force.norm() ? u.normalized().eval() : across(point.n);
    const Vector3d v = point.n.cross(u);
    column(point.p, point.n);
    const double mu = point.friction * (1 + kSlack);
    for (int k = 0; k < kEdges; ++k) {
      const double angle = k * kTurn;
      column(point.p, point.n + mu * (std::cos(angle) * u + std::sin(angle) * v));
    }
  }
  ConeTest::Vector6 w;
  w << wrench.force, (wrench.moment - centre_.cross(wrench.force)) / extent_;
  return test.holds(w);
}

}  // namespace aprsim::physics
