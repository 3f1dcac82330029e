// States from outside: every one with a wrong field is either refused or run without harm.

#include "tests/support/state_mutation.hpp"

#include <cstdlib>
#include <random>

#include <gtest/gtest.h>

namespace aprsim::test {
namespace {

TEST(MutatedState, IsRefusedOrRunsWithoutHarm) {
  const std::vector<GenuineState> states = genuine_states();
  for (const GenuineState& state : states) {
    EXPECT_TRUE(survives(state, state.bytes, 20)) << state.name;
  }
  std::mt19937_64 numbers(20261126);
  int refused = 0;
  constexpr int kMutations = 2000;
  for (int i = 0; i < kMutations; ++i) {
    const GenuineState& state = states[numbers() % states.size()];
    const std::string bytes = mutated(state, [&numbers] { return numbers(); });
    if (!survives(state, bytes, 10)) ++refused;
  }
  // Neither everything nor nothing: the fields were changed, and most of the changes are possible.
  EXPECT_GT(refused, kMutations / 10);
  EXPECT_LT(refused, kMutations * 9 / 10);
}

}  // namespace
}  // namespace aprsim::test
