#include "world/physics/bodies/force_guess.hpp"

#include <cmath>
#include <random>

#include <Eigen/Core>
#include <gtest/gtest.h>

namespace aprsim::physics {
namespace {

using Eigen::Vector3d;

TEST(ForceGuess, KnowsNoChangeAtFirst) {
  ForceGuess guess(Vector3d(1, 2, 3));
  EXPECT_EQ(guess.change, Vector3d(0, 0, 0));
  guess.record(Vector3d(4, 4, 4), false);
  EXPECT_EQ(guess.last, Vector3d(4, 4, 4));
  EXPECT_EQ(guess.change, Vector3d(0, 0, 0));
}

TEST(ForceGuess, FollowsAForceThatChangesEvenly) {
  ForceGuess guess(0.0);
  for (int i = 0; i < 5; ++i) guess.record(3 + 0.5 * i, false);
  EXPECT_EQ(guess.last + guess.change, 3 + 0.5 * 5);
  // And on, where the guess does.
  guess.record(guess.last + guess.change, true);
  EXPECT_EQ(guess.last + guess.change, 3 + 0.5 * 6);
}

/// A force that is off lets a body drift until a step stops it: what held it in the mean is what
/// was needed, for any mass, step, error and patience.
TEST(ForceGuess, OnceDriftIsPutRightIsTheForceThatWasNeeded) {
  std::mt19937_64 engine(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int round = 0; round < 1000; ++round) {
    const double kg = std::exp(4 * unit(engine)), h = 1e-3 * std::exp(unit(engine));
    const double needed = 20 * unit(engine), off = unit(engine);
    const int patience = 1 + static_cast<int>(30 * std::abs(unit(engine)));
    ForceGuess guess(needed + off);
    double v = 0;
    for (int i = 0; i < patience; ++i) {
      v += h / kg * (guess.last + guess.change - needed);
      guess.record(guess.last + guess.change, true);
    }
    guess.record(needed - v * kg / h, false);
    EXPECT_NEAR(guess.last, needed, 1e-10);
    EXPECT_EQ(guess.change, 0);
  }
}

}  // namespace
}  // namespace aprsim::physics
