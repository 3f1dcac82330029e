#pragma once

#include <random>

#include "tests/benchmarks/friction/verdict.hpp"
#include "world/scene/model/scene.hpp"

/// A plain cylinder between the pads of a gripper that falls freely with it, so that nothing but
/// the load that is asked for acts on the grip.
namespace aprsim::bench {

enum class GripLoad {
  kAcross,     ///< peg across the approach, flat pads, a force in the pads' plane: 2 mu F
  kAlong,      ///< peg along the approach, the same
  kTorsion,    ///< peg across the approach, a torque about the closing axis: 2 mu F l, with l from
               ///< the axis to the ends of the lines on which pads and peg touch
  kGroove,     ///< V pads, a force along the peg that has slid before: 2 mu F / sin(half angle)
  kFresh,      ///< the same as closed: friction across the groove adds to that or takes from it
  kWeakening,  ///< as kAlong, under the peg's weight, while the fingers' force sinks: 2 mu F = m g
};
const char* name_of(GripLoad load);

struct GripCase {
  scene::Simplification mode = scene::Simplification::kOff;
  GripLoad load = GripLoad::kAcross;
  double yaw_rad = 0;        ///< of the hand about the closing axis
  double tilt_rad = 0;       ///< of the closing axis, from the horizontal
  double heading_rad = 0;    ///< of the hand about the vertical
  double direction_rad = 0;  ///< of the force in the pads' plane
  double friction = 0.5;     ///< of the pads
  double force_n = 2;        ///< of each finger
  double limit_m_s2 = 15;    ///< the limit as an acceleration; the peg's mass follows
  double v_half_angle_rad = 0.8;
};

/// A load that grows to 0.9, 0.98 and 1.02 of its limit, with pauses.
[[nodiscard]] Verdict grip(const GripCase& the_case);

/// Largest load of a V groove under the fingers' force alone, over its load once the peg has slid:
/// 1 / sqrt(1 - (mu / tan(half angle))^2), or without bound. Friction across the groove then wedges
/// the peg against the flanks.
[[nodiscard]] double most_of_groove(const GripCase& the_case);

/// Friction, force, mass and heading from the seed; also the tilt, where `tilted`.
[[nodiscard]] GripCase random_grip(std::mt19937_64& engine, GripLoad load, bool tilted);

}  // namespace aprsim::bench
