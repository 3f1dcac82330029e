#include "world/scene/model/lens.hpp"

#include <Eigen/LU>

namespace aprsim::scene {
namespace {

/// Distorted direction and its derivative.
struct Distorted {
  Eigen::Vector2d at;
  Eigen::Matrix2d slope;
};

Distorted distort(const Eigen::Vector2d& u, const std::array<double, 5>& k) {
  const auto& [k1, k2, p1, p2, k3] = k;
  const double x = u.x(), y = u.y(), r2 = u.squaredNorm();
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double d_radial = 2 * (k1 + r2 * (2 * k2 + 3 * r2 * k3));  // times x or y
  Distorted out;
  out.at = radial * u + Eigen::Vector2d(2 * p1 * x * y + p2 * (r2 + 2 * x * x),
                                        p1 * (r2 + 2 * y * y) + 2 * p2 * x * y);
  out.slope << radial + d_radial * x * x + 2 * p1 * y + 6 * p2 * x,
      d_radial * x * y + 2 * p1 * x + 2 * p2 * y, d_radial * x * y + 2 * p1 * x + 2 * p2 * y,
      radial + d_radial * y * y + 6 * p1 * y + 2 * p2 * x;
  return out;
}

}  // namespace

Eigen::Vector2d Lens::pixel(const Eigen::Vector2d& direction) const {
  return distort(direction, distortion).at.cwiseProduct(focal_px) + centre_px;
}

std::optional<Eigen::Vector2d> Lens::direction(const Eigen::Vector2d& pixel) const {
  constexpr int kIterations = 50;
  constexpr double kConverged = 1e-13;
  const Eigen::Vector2d distorted = (pixel - centre_px).cwiseQuotient(focal_px);
  Eigen::Vector2d u = distorted;
  for (int i = 0; i < kIterations; ++i) {
    const Distorted now = distort(u, distortion);
    // A fold: what lies beyond it is shown twice, or never.
    if (!(now.slope.determinant() > 0) || !(now.slope.trace() > 0)) return std::nullopt;
    const Eigen::Vector2d step = now.slope.inverse() * (distorted - now.at);
    u += step;
    if (!u.allFinite()) return std::nullopt;
    if (step.squaredNorm() < kConverged * kConverged) return u;
  }
  return std::nullopt;
}

}  // namespace aprsim::scene
