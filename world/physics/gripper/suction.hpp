#pragma once

#include <span>

#include "world/scene/model/robot.hpp"

/// The air of a vacuum cup: pure functions of the gaps under its lip.
namespace aprsim::physics {

/// How a lip lies on what is under it.
struct LipSeal {
  double leak_m2 = 0;  ///< of all that is open under the lip
  double covered = 0;  ///< share of the lip with something within its reach
};

/// `gaps_m`: from the lip to the surface under it at evenly spaced points of its rim, infinite
/// where there is none. The lip follows a gap up to its compliance; a wider one is open in full, up
/// to the whole section of the cup.
[[nodiscard]] LipSeal seal_of(const scene::VacuumCup& cup, std::span<const double> gaps_m);

/// Vacuum at which the ejector's flow, falling linearly from its free flow to none at its highest
/// vacuum, is that through the leak (an orifice, incompressible) [Pa].
[[nodiscard]] double steady_vacuum(const scene::VacuumCup& cup, double leak_m2);

/// The cup's vacuum a step later [Pa], towards the steady one with its time constant, exactly.
[[nodiscard]] double advance_vacuum(const scene::VacuumCup& cup, bool on, const LipSeal& seal,
                                    double step_s, double vacuum_pa);

/// Force that holds a part at a vacuum: on the share of the cup's section that the part covers [N].
[[nodiscard]] double suction_force(const scene::VacuumCup& cup, double vacuum_pa, double covered);

}  // namespace aprsim::physics
