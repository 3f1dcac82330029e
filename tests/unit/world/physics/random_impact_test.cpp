// Invariants of impacts of free bodies: the energy never rises, momentum and angular momentum stay.

#include "tests/unit/world/physics/random_impact.hpp"

#include <gtest/gtest.h>

namespace aprsim::physics::test {
namespace {

bool expect_invariants(std::uint64_t seed, const ImpactRange& range) {
  const ImpactOutcome impact = random_impact(seed, range);
  EXPECT_LT(impact.energy_ratio, 1 + 1e-9) << "seed " << seed;
  EXPECT_LT(impact.momentum_error, 1e-12) << "seed " << seed;
  EXPECT_LT(impact.angular_momentum_error, 1e-9) << "seed " << seed;
  return impact.touched;
}

void expect_invariants_of_many(const ImpactRange& range) {
  constexpr std::uint64_t kImpacts = 1000;
  std::uint64_t touched = 0;
  for (std::uint64_t seed = 0; seed < kImpacts; ++seed) {
    touched += expect_invariants(seed, range) ? 1 : 0;
  }
  EXPECT_GT(touched, kImpacts / 2);
}

TEST(RandomImpact, MakesNoEnergyAndKeepsMomenta) { expect_invariants_of_many({}); }

TEST(RandomImpact, OfTraysWithOutlinesDoesSoToo) { expect_invariants_of_many({.outlines = true}); }

TEST(RandomImpact, WherePartsJamInEachOtherDoesSoToo) {
  // In one in ten thousand impacts a disc gets so far into another one within a step that contacts
  // contradict each other.
  for (const std::uint64_t seed : {13716U, 28105U, 105196U, 185321U, 804261U, 899115U}) {
    EXPECT_TRUE(expect_invariants(seed, {})) << "seed " << seed;
  }
}

}  // namespace
}  // namespace aprsim::physics::test
