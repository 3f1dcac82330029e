#include "world/runtime/health.hpp"

#include <gtest/gtest.h>

namespace aprsim::world {
namespace {

using namespace std::chrono_literals;

WallTime at(std::chrono::milliseconds time) { return WallTime{} + 1h + time; }

class HealthTest : public testing::Test {
 protected:
  [[nodiscard]] std::string problem(std::chrono::milliseconds time) const {
    return health_.problem(at(time), snapshot_);
  }
  void turn(std::chrono::milliseconds time, const Health::Load& load = {}) {
    health_.record_turn(at(time), load);
  }

  Health health_{8};
  api::Snapshot snapshot_;
};

TEST_F(HealthTest, NoProblemBeforeTheFirstTurn) {
  EXPECT_TRUE(health_.makes_progress(at(0ms)));
  EXPECT_EQ(problem(0ms), "");
}

TEST_F(HealthTest, AThreadWithoutATurnForASecondIsStuck) {
  turn(0ms);
  EXPECT_TRUE(health_.makes_progress(at(1000ms)));
  EXPECT_EQ(problem(1000ms), "");
  EXPECT_FALSE(health_.makes_progress(at(1001ms)));
  EXPECT_EQ(problem(2500ms), "the simulation has made no progress for 2.5 s");
  health_.end();
  EXPECT_TRUE(health_.makes_progress(at(2500ms))) << "no turn is expected after the end";
  EXPECT_EQ(problem(2500ms), "");
}

TEST_F(HealthTest, AQueueHalfFullForASecondIsAProblem) {
  for (auto time = 0ms; time <= 1100ms; time += 100ms) turn(time, {.waiting_commands = 5});
  EXPECT_EQ(problem(1100ms), "more than 4 commands have been waiting for 1.1 s");
  // Single turns with an empty queue do not end it.
  turn(1200ms);
  EXPECT_NE(problem(1200ms), "");
  turn(1300ms);
  EXPECT_EQ(problem(1300ms), "") << "not seen for 200 ms";
}

TEST_F(HealthTest, AQueueThatIsHalfFullIsNone) {
  for (auto time = 0ms; time <= 2000ms; time += 100ms) turn(time, {.waiting_commands = 4});
  EXPECT_EQ(problem(2000ms), "");
}

TEST_F(HealthTest, APaceBelowItsTargetForThreeSecondsIsAProblem) {
  snapshot_.speed_target = 2;
  snapshot_.real_time_factor = 1.5;
  const Health::Load slow{.speed = 2, .pace = 1.5};
  for (auto time = 0ms; time <= 3000ms; time += 100ms) turn(time, slow);
  EXPECT_EQ(problem(3000ms), "");
  turn(3100ms, slow);
  EXPECT_EQ(problem(3100ms), "the pace is 1.50 instead of 2");
  turn(3200ms, {.speed = 2, .pace = 1.81});
  EXPECT_EQ(problem(3200ms), "") << "within a tenth";
}

TEST_F(HealthTest, WithoutATargetOrAMeasurementNoPaceIsTooLow) {
  for (auto time = 0ms; time <= 5000ms; time += 100ms) turn(time, {.pace = 0.1});
  EXPECT_EQ(problem(5000ms), "");
  for (auto time = 5100ms; time <= 10'000ms; time += 100ms) turn(time, {.speed = 1});
  EXPECT_EQ(problem(10'000ms), "");
}

TEST_F(HealthTest, AWorldFaultComesBeforeAllElse) {
  turn(0ms);
  snapshot_.world_fault = "a gear is lost";
  EXPECT_EQ(problem(5000ms), "the simulation has stopped until the cell is reset: a gear is lost");
}

}  // namespace
}  // namespace aprsim::world
