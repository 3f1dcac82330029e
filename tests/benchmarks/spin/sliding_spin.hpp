#pragma once

#include <random>

#include "world/scene/model/scene.hpp"

/// A tray that slides and spins on a flat plate until it rests.
namespace aprsim::bench {

struct SpinCase {
  scene::Simplification mode = scene::Simplification::kOff;
  double step_s = 1e-3;
  double friction = 0.3;
  double speed_m_s = 0.5, heading_rad = 0;
  double spin_rad_s = 5;
  double tray_yaw_rad = 0;
};

struct SpinResult {
  double way_m = 0, yaw_rad = 0;            ///< as simulated
  double true_way_m = 0, true_yaw_rad = 0;  ///< by the reference
  double way_error = 0;                     ///< distance of both places of rest, over the way
  double yaw_error = 0;                     ///< relative
  /// The same against a reference whose velocity is the given one when it starts, not half a step
  /// before: that goes h v / 2 farther.
  double later_way_error = 0, later_yaw_error = 0;
};

/// The reference: one rigid body in the plane, Coulomb friction at the points where the simulated
/// tray touches the plate, integrated in steps of 10 us. The points share the weight, and what
/// friction below the centre of mass tips, as equally soft ones do: their forces are a linear
/// function of the place. Poses follow from velocities in the middle of steps, so the velocity that
/// is given is that of half a step before the start.
[[nodiscard]] SpinResult slide_and_spin(const SpinCase& the_case);

[[nodiscard]] SpinCase random_spin(std::mt19937_64& engine);

}  // namespace aprsim::bench
