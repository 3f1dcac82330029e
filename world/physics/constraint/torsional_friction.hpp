#pragma once

#include <array>

#include "world/base/simd/vec4d.hpp"

namespace aprsim::physics {

/// Friction torques of four contacts, each times the step: about n (spinning), within an interval,
/// and across n (rolling), within a disc, both in proportion to the normal impulse. Vectors are in
/// the contact frames (n, t1, t2).
struct TorsionalFriction {
  Vec4d spinning_m, rolling_m;         ///< limits per normal impulse
  Vec4d delassus_spin, delassus_roll;  ///< diagonal of J M^-1 J'
  Vec4d inverse_delassus_spin, inverse_delassus_roll;
  Vec4d inverse_R_spin, inverse_R_roll;  ///< of the regularization by the proximal term
  Vector3x4 impulse, proximal_impulse;
  Vector3x4 omega_c, delta_omega_c;  ///< relative angular velocity; its change along a direction
  Vec4d G_spin, G_roll_yy, G_roll_yz, G_roll_zz;  ///< -d impulse / d omega_c

  void set_delassus(const Vec4d& spin, const Vec4d& roll) {
    delassus_spin = spin;
    delassus_roll = roll;
    inverse_delassus_spin = inverse_or_zero(spin);
    inverse_delassus_roll = inverse_or_zero(roll);
  }
  void set_regularization(double weight) {
    inverse_R_spin = inverse_delassus_spin / weight;
    inverse_R_roll = inverse_delassus_roll / weight;
  }
  void set_open() {
    impulse = Vector3x4::zero();
    G_spin = G_roll_yy = G_roll_yz = G_roll_zz = broadcast(0);
  }
  [[nodiscard]] bool is_idle() const {
    return !any((impulse.x != 0) | (impulse.y != 0) | (impulse.z != 0));
  }
  /// The impulses that belong to the velocities omega, and their derivatives. `gamma_n` is the
  /// normal impulse that bounds them.
  void evaluate_impulses(const Vector3x4& omega, const Vec4d& gamma_n);
  /// Natural maps, in units of velocity at a lever.
  [[nodiscard]] Vec4d spinning_residual(const Vec4d& gamma_n, double lever_m) const;
  [[nodiscard]] Vec4d rolling_residual(const Vec4d& gamma_n, double lever_m) const;
  /// Rows of G times the contact frame.
  [[nodiscard]] std::array<Vector3x4, 3> derivative_rows(
      const std::array<Vector3x4, 3>& frame) const {
    return {G_spin * frame[0], G_roll_yy * frame[1] + G_roll_yz * frame[2],
            G_roll_yz * frame[1] + G_roll_zz * frame[2]};
  }
};

inline void TorsionalFriction::evaluate_impulses(const Vector3x4& omega, const Vec4d& gamma_n) {
  // Spinning: within an interval.
  const Vec4d limit = spinning_m * gamma_n;
  const Vec4d spin = proximal_impulse.x - inverse_R_spin * omega.x;
  impulse.x = clamp_abs(spin, limit);
  G_spin = abs(spin) < limit ? inverse_R_spin : broadcast(0);
  // Rolling: within a disc.
  const Vec4d y = proximal_impulse.y - inverse_R_roll * omega.y,
              z = proximal_impulse.z - inverse_R_roll * omega.z;
  const Vec4d radius = rolling_m * gamma_n, size = sqrt(y * y + z * z);
  const Mask4 within = size < radius;
  const Vec4d inverse_size = inverse_or_zero(size);
  const Vec4d ty = y * inverse_size, tz = z * inverse_size;
  const Vec4d scale = within ? broadcast(1) : radius * inverse_size;
  const Vec4d around = inverse_R_roll * scale;
  impulse.y = scale * y;
  impulse.z = scale * z;
  G_roll_yy = within ? inverse_R_roll : around * tz * tz;
  G_roll_zz = within ? inverse_R_roll : around * ty * ty;
  G_roll_yz = within ? broadcast(0) : -around * ty * tz;
}

inline Vec4d TorsionalFriction::spinning_residual(const Vec4d& gamma_n, double lever_m) const {
  const Vec4d off =
      impulse.x - clamp_abs(impulse.x - inverse_delassus_spin * omega_c.x, spinning_m * gamma_n);
  return lever_m * delassus_spin * abs(off);
}

inline Vec4d TorsionalFriction::rolling_residual(const Vec4d& gamma_n, double lever_m) const {
  const Vec4d y = impulse.y - inverse_delassus_roll * omega_c.y,
              z = impulse.z - inverse_delassus_roll * omega_c.z;
  const Vec4d radius = rolling_m * gamma_n, size = sqrt(y * y + z * z);
  const Vec4d scale = size <= radius ? broadcast(1) : radius * inverse_or_zero(size);
  const Vec4d off_y = impulse.y - scale * y, off_z = impulse.z - scale * z;
  return lever_m * delassus_roll * sqrt(off_y * off_y + off_z * off_z);
}

}  // namespace aprsim::physics
