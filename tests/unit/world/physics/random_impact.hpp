#pragma once

#include <cstdint>

namespace aprsim::physics::test {

/// Outcome of an impact of two free bodies, compared with the state before it.
struct ImpactOutcome {
  bool touched = false;
  double energy_ratio = 1;    ///< greatest kinetic energy in any step over that before
  double momentum_error = 0;  ///< relative to the sum of the bodies' momenta
  /// The same of the angular momentum about the common centre of mass.
  double angular_momentum_error = 0;
};

/// Ranges of random impacts. SI.
struct ImpactRange {
  double max_speed_m_s = 10, max_omega_rad_s = 30;
  double max_restitution = 1, max_friction = 1;
  double max_residual_m_s = 1e-8;  ///< see scene::Physics
  bool outlines = false;           ///< trays are polygons with cut corners, no boxes
  bool parts = false;              ///< the first body is a part of one or two random pieces
};

/// Throws a random part at another one in free space, without gravity: gears and trays of random
/// types, attitudes, velocities, friction and restitution. The same seed gives the same impact.
[[nodiscard]] ImpactOutcome random_impact(std::uint64_t seed, const ImpactRange& range = {});

}  // namespace aprsim::physics::test
