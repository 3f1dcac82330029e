// Contents of the history, and how long it keeps them.

#include "world/runtime/history/history_records.hpp"

#include <algorithm>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "world/runtime/history/recorders.hpp"

namespace aprsim::world {
namespace {

QueuedCommand command(api::Ticket ticket) {
  return {ticket, {.endpoint = 16, .body = api::RobotCommand{0, api::InitRobot{}}}};
}

/// As a simulation tells it, without a world.
class ToldRun {
 public:
  explicit ToldRun(Recorder& recorder) : recorder_(recorder) { begin(0); }
  void begin(std::uint64_t step, const std::string* loaded = nullptr) {
    now_.step = step;
    recorder_.began(now_, 1, loaded, nullptr);
    recorder_.saved(now_, 0, std::make_shared<const WorldState>());
  }
  void reset() {
    ++now_.epoch;
    begin(0);
  }
  void steps(std::uint64_t count) {
    for (; count > 0; --count) {
      ++now_.step;
      if (now_.step % kSampleSteps == 0) recorder_.sampled(now_, {});
      if (now_.step % kCheckpointSteps == 0 || recorder_.wants_checkpoint()) {
        ++checkpoints;
        recorder_.saved(now_, 0, std::make_shared<const WorldState>());
      }
    }
  }
  void apply(api::Ticket ticket) { apply(command(ticket)); }
  void apply(const QueuedCommand& command) { recorder_.applied(now_, command, nullptr); }
  int checkpoints = 0;

 private:
  Recorder& recorder_;
  RunTime now_;
};

TEST(HistoryRecords, LeadToAMomentFromTheLastCheckpointBeforeIt) {
  HistoryRecords records({});
  ToldRun run(records);
  run.apply(1);
  run.steps(2500);
  run.apply(2);
  run.steps(500);
  run.apply(3);
  run.steps(100);
  const auto course = records.course_to({0, 3000});
  ASSERT_TRUE(course);
  EXPECT_EQ(course->begin, (RunTime{0, 2000}));
  ASSERT_EQ(course->commands.size(), 1U) << "before the moment, not at it";
  EXPECT_EQ(course->commands[0]->command.ticket, 2U);
  const auto first = records.course_to({0, 2000 - 1});
  ASSERT_TRUE(first);
  ASSERT_EQ(first->commands.size(), 1U);
  EXPECT_EQ(first->commands[0]->command.ticket, 1U);
  EXPECT_TRUE(records.course_to({0, 0}));
}

TEST(HistoryRecords, AskForCheckpointsAsDenseAsTheyAreToBe) {
  HistoryRecords records({.checkpoint_steps = 2000});
  ToldRun run(records);
  run.steps(20'000);
  EXPECT_EQ(run.checkpoints, 10);
}

// A flood of long paths: the past gets shorter, not larger.
TEST(HistoryRecords, CountTheWaypointsOfCommands) {
  constexpr std::uint64_t kBytes = 4 << 20;
  HistoryRecords records({.bytes = kBytes});
  ToldRun run(records);
  std::uint64_t told = 0, most = 0;
  for (api::Ticket ticket = 1; ticket < 1000; ++ticket) {
    QueuedCommand path = command(ticket);
    path.command.body =
        api::RobotCommand{0, api::MoveThroughTo{std::vector<api::Waypoint>(230), false}};
    told += 230 * sizeof(api::Waypoint);
    run.apply(path);
    run.steps(1);
    most = std::max(most, records.bytes());
  }
  EXPECT_GT(told, 4 * kBytes);
  EXPECT_LT(most, kBytes + kBytes / 4);
  EXPECT_GT(most, kBytes / 2);
  EXPECT_TRUE(records.keeps({0, 998}));
  EXPECT_FALSE(records.keeps({0, 1}));
}

TEST(HistoryRecords, KeepEveryEpochWithWhatItBeganWith) {
  HistoryRecords records({});
  ToldRun run(records);
  run.steps(1500);
  run.apply(1);
  run.reset();
  run.steps(10);
  records.reach({1, 10});
  const auto spans = records.spans();
  ASSERT_EQ(spans.size(), 2U);
  EXPECT_EQ(spans[0].last_step, 1500U);
  EXPECT_EQ(spans[1].epoch, 1U);
  EXPECT_EQ(spans[1].last_step, 10U);
  EXPECT_TRUE(records.keeps({0, 1500}));
  EXPECT_FALSE(records.keeps({0, 1501}));
  EXPECT_TRUE(records.keeps({1, 0}));
  EXPECT_FALSE(records.keeps({1, 11}));
}

TEST(HistoryRecords, GiveTheOldestUpByStepsAndByBytes) {
  HistoryRecords by_steps({.steps = 10'000});
  ToldRun run(by_steps);
  run.steps(50'000);
  EXPECT_TRUE(by_steps.keeps({0, 40'000}));
  EXPECT_FALSE(by_steps.keeps({0, 30'000}));
  EXPECT_EQ(by_steps.spans().size(), 1U);
  EXPECT_GE(by_steps.spans()[0].first_step, 36'000U);

  HistoryRecords by_bytes({.bytes = 20'000});
  ToldRun other(by_bytes);
  for (int i = 0; i < 100; ++i) {
    other.steps(1000);
    other.apply(1);
  }
  EXPECT_LE(by_bytes.bytes(), 20'000U);
  EXPECT_TRUE(by_bytes.keeps({0, 99'999}));
}

TEST(HistoryRecords, HoldTheirBoundsWhenACellIsResetAllTheTime) {
  HistoryRecords records({});
  ToldRun run(records);
  for (int i = 0; i < 10'000; ++i) run.reset();
  EXPECT_LE(records.spans().size(), 4000U);
}

TEST(Recorders, GiveACheckpointToWhoHasAskedForIt) {
  HistoryRecords dense({.checkpoint_steps = 1000});
  HistoryRecords sparse({.checkpoint_steps = 10'000});
  Recorders both({&dense, nullptr, &sparse});
  ToldRun run(both);
  run.steps(10'000);
  EXPECT_EQ(dense.course_to({0, 9500})->begin.step, 9000U);
  EXPECT_EQ(sparse.course_to({0, 9500})->begin.step, 0U);
  EXPECT_TRUE(sparse.course_to({0, 10'000})->begin.step == 10'000U);
}

}  // namespace
}  // namespace aprsim::world
