// Invariants of impacts of free bodies: the energy never rises, momentum and angular momentum stay.

#include "tests/unit/world/physics/random_impact.hpp"

#include <gtest/gtest.h>

namespace aprsim::physics::test {
namespace {

TEST(RandomImpact, MakesNoEnergyAndKeepsMomenta) {
  constexpr std::uint64_t kImpacts = 1000;
  std::uint64_t touched = 0;
  for (std::uint64_t seed = 0; seed < kImpacts; ++seed) {
    const ImpactOutcome impact = random_impact(seed);
    touched += impact.touched ? 1 : 0;
    EXPECT_LT(impact.energy_ratio, 1 + 1e-9) << "seed " << seed;
    EXPECT_LT(impact.momentum_error, 1e-12) << "seed " << seed;
    EXPECT_LT(impact.angular_momentum_error, 1e-10) << "seed " << seed;
  }
  EXPECT_GT(touched, kImpacts / 2);
}

}  // namespace
}  // namespace aprsim::physics::test
