#include "tests/unit/world/physics/jams.hpp"

#include <algorithm>

#include <gtest/gtest.h>

namespace aprsim::physics::test {
namespace {

using scene::Simplification;

// `off` against itself, started 0.14 um elsewhere, ends up to 0.48 mm apart (experiment `jams`).
constexpr double kSame = 5e-4;  // [m]

struct Case {
  Jam jam;
  unsigned seed;
};
void PrintTo(const Case& shown, std::ostream* out) { *out << name_of(shown.jam) << shown.seed; }

class Jams : public testing::TestWithParam<Case> {};

TEST_P(Jams, EndTheSameInEveryMode) {
  const auto [jam, seed] = GetParam();
  const JamOutcome off = run_jam(jam, Simplification::kOff, seed);
  for (const auto mode : {Simplification::kMerge, Simplification::kDormant}) {
    SCOPED_TRACE(mode == Simplification::kMerge ? "merge" : "dormant");
    const JamOutcome out = run_jam(jam, mode, seed);
    EXPECT_LT(farthest_apart(out.pressed, off.pressed), kSame);
    EXPECT_LT(farthest_apart(out.left, off.left), kSame);
    EXPECT_EQ(out.resting, off.resting);
    // Sleeping bodies are not penetrated.
    EXPECT_NEAR(out.deepest_m, off.deepest_m, 1e-4);
  }
  EXPECT_EQ(std::count(off.resting.begin(), off.resting.end(), false), 0);
  EXPECT_LT(off.deepest_m, 5e-4);
}

INSTANTIATE_TEST_SUITE_P(Modes, Jams,
                         testing::Values(Case{Jam::kQueue, 1}, Case{Jam::kQueue, 7},
                                         Case{Jam::kWedge, 3}, Case{Jam::kCorner, 2}),
                         [](const auto& one) {
                           return name_of(one.param.jam) + std::to_string(one.param.seed);
                         });

}  // namespace
}  // namespace aprsim::physics::test
