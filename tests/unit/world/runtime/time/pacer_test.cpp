#include "world/runtime/time/pacer.hpp"

#include <gtest/gtest.h>

namespace aprsim::world {
namespace {

using namespace std::chrono_literals;

constexpr std::chrono::nanoseconds kStep = 1ms;
const WallTime kStart{};

/// Takes everything due at `now`, as the simulation's thread does.
int steps_due(Pacer& pacer, WallTime now) {
  const int steps = pacer.due(now);
  for (int i = 0; i < steps; ++i) pacer.stepped(now, 100us);
  return steps;
}

TEST(Pacer, StepsOncePerStepOfWallTime) {
  Pacer pacer(kStep, kStart);
  EXPECT_EQ(steps_due(pacer, kStart), 0);
  EXPECT_EQ(pacer.next(kStart), kStart + 1ms);
  EXPECT_EQ(steps_due(pacer, kStart + 1ms), 1);
  EXPECT_EQ(steps_due(pacer, kStart + 1ms), 0);
  EXPECT_EQ(steps_due(pacer, kStart + 3ms), 2);
  EXPECT_EQ(pacer.missed_steps(), 0U);
}

TEST(Pacer, SpeedFactorScalesTheRateOnly) {
  Pacer pacer(kStep, kStart);
  pacer.set_speed(2.0, kStart);
  EXPECT_EQ(steps_due(pacer, kStart + 1ms), 2);
  pacer.set_speed(0.5, kStart + 1ms);
  EXPECT_EQ(steps_due(pacer, kStart + 2ms), 0);
  EXPECT_EQ(steps_due(pacer, kStart + 3ms), 1);
}

TEST(Pacer, ShortLatenessIsCaughtUpInBursts) {
  Pacer pacer(kStep, kStart);
  const WallTime late = kStart + 20ms;
  int total = 0;
  while (const int steps = steps_due(pacer, late)) {
    EXPECT_LE(steps, 5);
    total += steps;
  }
  EXPECT_EQ(total, 20);
  EXPECT_EQ(pacer.missed_steps(), 0U);
}

TEST(Pacer, LongLatenessIsGivenUpAndCounted) {
  Pacer pacer(kStep, kStart);
  const WallTime late = kStart + 1000ms;
  int total = 0;
  while (const int steps = steps_due(pacer, late)) total += steps;
  EXPECT_EQ(total, 5);
  EXPECT_EQ(pacer.missed_steps(), 995U);
  EXPECT_EQ(steps_due(pacer, late + 1ms), 1);
}

TEST(Pacer, AsFastAsPossibleIsAlwaysDue) {
  Pacer pacer(kStep, kStart);
  pacer.set_speed(std::nullopt, kStart);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(steps_due(pacer, kStart), 1);
  EXPECT_EQ(pacer.next(kStart), kStart);
}

TEST(Pacer, MeasuresRealTimeFactorAndStepTime) {
  Pacer pacer(kStep, kStart);
  pacer.set_speed(3.0, kStart);
  for (auto t = 0ms; t <= 1100ms; t += 1ms) steps_due(pacer, kStart + t);
  EXPECT_NEAR(pacer.real_time_factor(), 3.0, 0.02);
  EXPECT_NEAR(pacer.step_time_s(), 1e-4, 1e-9);
  pacer.measure(kStart + 3000ms);
  EXPECT_LT(pacer.real_time_factor(), 0.01) << "a pause must not keep the old factor";
}

}  // namespace
}  // namespace aprsim::world
