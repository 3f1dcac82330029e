#include "world/physics/gripper/suction_cup.hpp"

#include <cmath>

namespace aprsim::physics {

bool SuctionCup::has_suction(bool ejector_on) const {
  constexpr double kSpent_Pa = 1;
  return ejector_on || state_.vacuum_pa > kSpent_Pa;
}

void SuctionCup::advance(bool ejector_on, const LipSeal& seal, int body, double share,
                         double step_s) {
  constexpr double kSteadyVacuum = 0.01;  // share of the highest vacuum
  const double end = ejector_on ? steady_vacuum(cup_, seal.leak_m2) : 0;
  state_.vacuum_pa = advance_vacuum(cup_, ejector_on, seal, step_s, state_.vacuum_pa);
  state_.steady = std::abs(state_.vacuum_pa - end) < kSteadyVacuum * cup_.max_vacuum_pa;
  state_.suction = {body, suction_force(cup_, state_.vacuum_pa, share)};
}

}  // namespace aprsim::physics
