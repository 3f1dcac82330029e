#pragma once

#include "world/base/simd/vec4d.hpp"

namespace aprsim::physics {

/// G = -d gamma / d v_c in the frames of four contacts.
struct ImpulseDerivative {
  Vec4d at[3][3];

  static ImpulseDerivative zero() {
    ImpulseDerivative out;
    for (auto& row : out.at) {
      for (Vec4d& value : row) value = broadcast(0);
    }
    return out;
  }
};

/// Coulomb's cones |gamma_t| <= mu gamma_n of four contacts, with the metric diag(n, t, t) in which
/// impulses are projected. In a lane without a metric the cone is only its tip.
struct FrictionCone {
  Vec4d mu, n, t;
  Vec4d inverse_n, inverse_t;
  Vec4d polar_slope;      ///< mu t / n: slope of the polar cone in the metric
  Vec4d generator_scale;  ///< 1 / (1 + mu^2 t / n)

  void set(const Vec4d& friction, const Vec4d& metric_n, const Vec4d& metric_t);
  /// Projection onto the cone in its metric. `G`, if wanted, becomes the derivative of the
  /// projection times the inverse of the metric.
  [[nodiscard]] Vector3x4 project(const Vector3x4& z, ImpulseDerivative* G = nullptr) const;
};

inline void FrictionCone::set(const Vec4d& friction, const Vec4d& metric_n, const Vec4d& metric_t) {
  mu = friction;
  n = metric_n;
  t = metric_t;
  inverse_n = inverse_or_zero(n);
  inverse_t = inverse_or_zero(t);
  polar_slope = mu * t * inverse_n;
  generator_scale = 1 / (1 + mu * polar_slope);
}

/// The three cases of SAP's analytical inverse dynamics (Castro et al. 2022): within the
/// cone (stiction), within the polar cone (no contact), else onto the surface (sliding).
inline Vector3x4 FrictionCone::project(const Vector3x4& z, ImpulseDerivative* G) const {
  const Vec4d zero = broadcast(0);
  const Vec4d z_t = sqrt(z.y * z.y + z.z * z.z);
  const Mask4 sticks = (z.x >= 0) & (z_t <= mu * z.x);
  const Mask4 opens = z.x <= -polar_slope * z_t;
  const auto choose = [&](const Vec4d& sticking, const Vec4d& sliding) {
    return sticks ? sticking : opens ? zero : sliding;
  };
  // Sliding: onto the cone's generator, along the metric's normal.
  const Vec4d gamma_n = generator_scale * (z.x + polar_slope * z_t), gamma_t = mu * gamma_n;
  const Vec4d inverse_z_t = inverse_or_zero(z_t);
  const Vec4d ty = z_t > 0 ? z.y * inverse_z_t : broadcast(1), tz = z.z * inverse_z_t;
  if (G != nullptr) {
    // Derivative along the generator (nn, nt, tt), and around the cone's axis.
    const Vec4d nn = generator_scale * inverse_n, nt = mu * nn, tt = mu * nt,
                around = gamma_t * inverse_z_t * inverse_t;
    auto& g = G->at;
    g[0][0] = choose(inverse_n, nn);
    g[0][1] = g[1][0] = choose(zero, nt * ty);
    g[0][2] = g[2][0] = choose(zero, nt * tz);
    g[1][1] = choose(inverse_t, tt * ty * ty + around * tz * tz);
    g[2][2] = choose(inverse_t, tt * tz * tz + around * ty * ty);
    g[1][2] = g[2][1] = choose(zero, (tt - around) * ty * tz);
  }
  return {choose(z.x, gamma_n), choose(z.y, gamma_t * ty), choose(z.z, gamma_t * tz)};
}

}  // namespace aprsim::physics
