// Invariants of impacts of free bodies: the energy never rises, momentum and angular momentum stay.

#include "tests/unit/world/physics/random_impact.hpp"

#include <gtest/gtest.h>

namespace aprsim::physics::test {
namespace {

void expect_invariants(std::uint64_t impacts, const ImpactRange& range) {
  std::uint64_t touched = 0;
  for (std::uint64_t seed = 0; seed < impacts; ++seed) {
    const ImpactOutcome impact = random_impact(seed, range);
    touched += impact.touched ? 1 : 0;
    EXPECT_LT(impact.energy_ratio, 1 + 1e-9) << "seed " << seed;
    EXPECT_LT(impact.momentum_error, 1e-12) << "seed " << seed;
    EXPECT_LT(impact.angular_momentum_error, 1e-10) << "seed " << seed;
  }
  EXPECT_GT(touched, impacts / 2);
}

TEST(RandomImpact, MakesNoEnergyAndKeepsMomenta) { expect_invariants(1000, {}); }

TEST(RandomImpact, OfTraysWithOutlinesDoesSoToo) { expect_invariants(1000, {.outlines = true}); }

}  // namespace
}  // namespace aprsim::physics::test
