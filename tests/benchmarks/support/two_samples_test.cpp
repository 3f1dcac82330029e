#include "tests/benchmarks/support/two_samples.hpp"

#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

namespace aprsim::bench {
namespace {

/// Runs of two measures that hang together; the second is shifted.
std::vector<Measures> normal(unsigned seed, std::size_t runs, double shift) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> draw;
  std::vector<Measures> out;
  for (std::size_t i = 0; i < runs; ++i) {
    const double x = draw(engine);
    out.push_back({x, 0.5 * x + draw(engine) + shift});
  }
  return out;
}

TEST(TwoSamples, DistanceIsKolmogorovAndSmirnovs) {
  // Worked out by hand: after 1 and 2 of a, none of b: 2/3; ties count at their end.
  const TwoSamples test = compare({{1}, {2}, {5}}, {{5}, {5}, {7}, {8}}, 99);
  EXPECT_DOUBLE_EQ(test.distance, 2.0 / 3);
  EXPECT_EQ(test.distances, std::vector<double>{2.0 / 3});
  EXPECT_DOUBLE_EQ(compare({{1}, {2}}, {{1}, {2}}, 99).distance, 0);
}

TEST(TwoSamples, PIsTheShareOfAllWaysToDivide) {
  // Two of the 20 ways to divide six runs into threes are as far apart as these.
  const TwoSamples test = compare({{1}, {2}, {3}}, {{4}, {5}, {6}}, 40000);
  EXPECT_DOUBLE_EQ(test.distance, 1);
  EXPECT_NEAR(test.p, 0.1, 0.005);
}

TEST(TwoSamples, EqualSamplesAreNoEvidence) {
  EXPECT_DOUBLE_EQ(compare({{1, 2}, {3, 4}}, {{1, 2}, {3, 4}}, 199).p, 1);
  EXPECT_DOUBLE_EQ(compare({{0}, {0}, {0}}, {{0}, {0}}, 199).p, 1);
}

TEST(TwoSamples, FalseAlarmsAreAsRareAsTheySay) {
  int below = 0;
  constexpr int kTests = 400;
  for (unsigned i = 0; i < kTests; ++i) {
    below += compare(normal(2 * i, 20, 0), normal(2 * i + 1, 20, 0), 99, i).p <= 0.1;
  }
  // Four standard deviations of a binomial distribution about 0.1; fewer, as distances have ties.
  EXPECT_LE(below, 64);
  EXPECT_GE(below, 8);
}

TEST(TwoSamples, AShiftOfOneMeasureIsFoundAndNamed) {
  int found = 0;
  for (unsigned i = 0; i < 20; ++i) {
    const TwoSamples test = compare(normal(2 * i, 60, 0), normal(2 * i + 1, 60, 1.2), 999, i);
    found += test.p <= 0.01 && test.measure == 1;
  }
  EXPECT_GE(found, 19);
}

TEST(TwoSamples, TheSameSeedGivesTheSameP) {
  const auto a = normal(1, 20, 0), b = normal(2, 20, 0.5);
  EXPECT_EQ(compare(a, b, 999, 3).p, compare(a, b, 999, 3).p);
}

TEST(TwoSamples, WantsRunsOfTheSameMeasures) {
  EXPECT_THROW(static_cast<void>(compare({}, {{1}})), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(compare({{1}}, {})), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(compare({{1, 2}}, {{1}})), std::invalid_argument);
}

}  // namespace
}  // namespace aprsim::bench
