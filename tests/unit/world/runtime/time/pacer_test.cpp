#include "world/runtime/time/pacer.hpp"

#include <gtest/gtest.h>

namespace aprsim::world {
namespace {

using namespace std::chrono_literals;

constexpr std::chrono::nanoseconds kStep = 1ms;
const WallTime kPacerStart{};

/// Takes everything due at `now`, as the simulation's thread does.
int steps_due(Pacer& pacer, WallTime now) {
  const int steps = pacer.due(now);
  for (int i = 0; i < steps; ++i) pacer.stepped(now, 100us);
  return steps;
}

TEST(Pacer, StepsOncePerStepOfWallTime) {
  Pacer pacer(kStep, kPacerStart);
  EXPECT_EQ(steps_due(pacer, kPacerStart), 0);
  EXPECT_EQ(pacer.next(kPacerStart), kPacerStart + 1ms);
  EXPECT_EQ(steps_due(pacer, kPacerStart + 1ms), 1);
  EXPECT_EQ(steps_due(pacer, kPacerStart + 1ms), 0);
  EXPECT_EQ(steps_due(pacer, kPacerStart + 3ms), 2);
  EXPECT_EQ(pacer.missed_steps(), 0U);
}

TEST(Pacer, SpeedFactorScalesTheRateOnly) {
  Pacer pacer(kStep, kPacerStart);
  pacer.set_speed(2.0, kPacerStart);
  EXPECT_EQ(steps_due(pacer, kPacerStart + 1ms), 2);
  pacer.set_speed(0.5, kPacerStart + 1ms);
  EXPECT_EQ(steps_due(pacer, kPacerStart + 2ms), 0);
  EXPECT_EQ(steps_due(pacer, kPacerStart + 3ms), 1);
}

TEST(Pacer, ShortLatenessIsCaughtUpInBursts) {
  Pacer pacer(kStep, kPacerStart);
  const WallTime late = kPacerStart + 20ms;
  int total = 0;
  while (const int steps = steps_due(pacer, late)) {
    EXPECT_LE(steps, 5);
    total += steps;
  }
  EXPECT_EQ(total, 20);
  EXPECT_EQ(pacer.missed_steps(), 0U);
}

TEST(Pacer, LongLatenessIsGivenUpAndCounted) {
  Pacer pacer(kStep, kPacerStart);
  const WallTime late = kPacerStart + 1000ms;
  int total = 0;
  while (const int steps = steps_due(pacer, late)) total += steps;
  EXPECT_EQ(total, 5);
  EXPECT_EQ(pacer.missed_steps(), 995U);
  EXPECT_EQ(steps_due(pacer, late + 1ms), 1);
}

TEST(Pacer, AsFastAsPossibleIsAlwaysDue) {
  Pacer pacer(kStep, kPacerStart);
  pacer.set_speed(std::nullopt, kPacerStart);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(steps_due(pacer, kPacerStart), 1);
  EXPECT_EQ(pacer.next(kPacerStart), kPacerStart);
}

TEST(Pacer, MeasuresRealTimeFactorAndStepTime) {
  Pacer pacer(kStep, kPacerStart);
  pacer.set_speed(3.0, kPacerStart);
  for (auto t = 0ms; t <= 1100ms; t += 1ms) steps_due(pacer, kPacerStart + t);
  EXPECT_NEAR(pacer.real_time_factor(), 3.0, 0.02);
  EXPECT_NEAR(pacer.step_time_s(), 1e-4, 1e-9);
  pacer.measure(kPacerStart + 3000ms);
  EXPECT_LT(pacer.real_time_factor(), 0.01) << "a pause must not keep the old factor";
}

}  // namespace
}  // namespace aprsim::world
