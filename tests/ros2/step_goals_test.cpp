// Goals of SimulateSteps: batches, cancels and refusals of the daemon.

#include "clients/ros2/simulation/step_goals.hpp"

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace aprsim::ros2 {
namespace {

GoalId id_of(std::uint8_t number) {
  GoalId id{};
  id.fill(number);
  return id;
}

GoalState state_of(const StepGoals& goals, const GoalId& id) {
  const GoalEntry* const goal = goals.goals().find(id);
  return goal ? goal->state : GoalState::kUnknown;
}

TEST(Ros2StepGoals, RandomGoalsTakeExactlyTheirSteps) {
  std::mt19937 random(3);
  for (std::uint8_t i = 1; i < 100; ++i) {
    const std::uint64_t steps = 1 + random() % (i % 2 == 0 ? 100 : 2000);
    StepGoals goals;
    ASSERT_EQ(goals.accept(id_of(i), steps, {}), "");
    EXPECT_NE(goals.accept(id_of(200), 1, {}), "") << "one goal at a time";
    std::uint64_t taken = 0, calls = 0, last = 0;
    while (goals.is_active()) {
      EXPECT_EQ(state_of(goals, id_of(i)), GoalState::kExecuting);
      const auto progress = goals.advance([&](std::uint64_t batch) {
        taken += batch;
        ++calls;
        return SimulationResult{};
      });
      ASSERT_TRUE(progress);
      EXPECT_EQ(progress->completed, taken);
      EXPECT_EQ(progress->completed + progress->remaining, steps);
      EXPECT_GT(progress->completed, last);
      last = progress->completed;
    }
    EXPECT_EQ(taken, steps);
    EXPECT_EQ(calls, steps <= 100 ? steps : (steps + 9) / 10) << "each step of a short goal";
    EXPECT_EQ(state_of(goals, id_of(i)), GoalState::kSucceeded);
    EXPECT_EQ(goals.goals().find(id_of(i))->result.error_code, kOk);
    EXPECT_FALSE(goals.advance([](std::uint64_t) { return SimulationResult{}; }));
  }
}

TEST(Ros2StepGoals, ACancelledGoalTakesNoMoreSteps) {
  std::mt19937 random(4);
  for (int i = 0; i < 50; ++i) {
    StepGoals goals;
    const std::uint64_t steps = 2 + random() % 90, until = random() % steps;
    ASSERT_EQ(goals.accept(id_of(1), steps, {}), "");
    std::uint64_t taken = 0;
    const auto step = [&](std::uint64_t batch) {
      taken += batch;
      return SimulationResult{};
    };
    while (taken < until) goals.advance(step);
    EXPECT_EQ(goals.cancel(id_of(9), {}).return_code, 2) << "unknown";
    EXPECT_TRUE(goals.is_active());
    EXPECT_EQ(goals.cancel(id_of(1), {}).goals.size(), 1U);
    EXPECT_FALSE(goals.is_active());
    EXPECT_FALSE(goals.advance(step));
    EXPECT_EQ(taken, until);
    EXPECT_EQ(state_of(goals, id_of(1)), GoalState::kCanceled);
    const std::string words = goals.goals().find(id_of(1))->result.error_string;
    EXPECT_EQ(words, "cancelled after " + std::to_string(until) + " of " + std::to_string(steps) +
                         " steps");
    EXPECT_EQ(goals.cancel(id_of(1), {}).return_code, 3) << "has ended";
    EXPECT_EQ(goals.accept(id_of(2), 1, {}), "") << "a new goal is taken";
  }
}

TEST(Ros2StepGoals, ARefusedStepAbortsWithTheDaemonsWords) {
  StepGoals goals;
  EXPECT_NE(goals.accept(id_of(1), 0, {}).find("found 0"), std::string::npos);
  ASSERT_EQ(goals.accept(id_of(1), 5, {}), "");
  EXPECT_TRUE(goals.advance([](std::uint64_t) { return SimulationResult{}; }));
  EXPECT_FALSE(goals.advance([](std::uint64_t) { return SimulationResult{kFailed, "it runs"}; }));
  EXPECT_FALSE(goals.is_active());
  EXPECT_EQ(state_of(goals, id_of(1)), GoalState::kAborted);
  EXPECT_EQ(goals.goals().find(id_of(1))->result.error_code, kFailed);
  EXPECT_EQ(goals.goals().find(id_of(1))->result.error_string, "it runs");
  EXPECT_NE(goals.accept(id_of(1), 5, {}), "") << "the identifier is in use";
}

}  // namespace
}  // namespace aprsim::ros2
