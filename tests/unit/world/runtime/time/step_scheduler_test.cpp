#include "world/runtime/time/step_scheduler.hpp"

#include <gtest/gtest.h>

namespace aprsim::world {
namespace {

using namespace std::chrono_literals;

const WallTime kStart{};

void take_steps(StepScheduler& scheduler, int count, WallTime now) {
  for (; count > 0; --count) {
    scheduler.stepped(now, 100us);
    (void)scheduler.published({}, now);
  }
}

TEST(StepScheduler, WithoutClientsTheWallClockPaces) {
  StepScheduler scheduler(
      {.step = 1ms, .speed = 2}, [] {}, kStart);
  EXPECT_FALSE(scheduler.update(kStart));
  EXPECT_FALSE(scheduler.is_paced());
  EXPECT_EQ(scheduler.virtual_time(), nullptr);
  EXPECT_EQ(scheduler.steps_due(kStart + 1ms), 2);
  take_steps(scheduler, 2, kStart + 1ms);
  EXPECT_EQ(scheduler.next_turn(kStart + 1ms), kStart + 1500us);
  api::Snapshot snapshot;
  scheduler.write(snapshot);
  EXPECT_EQ(snapshot.speed_target, 2);
  EXPECT_FALSE(snapshot.virtual_time);
}

TEST(StepScheduler, CommandsSetTheSpeedAndRestartTheCount) {
  StepScheduler scheduler(
      {.step = 1ms, .speed = 1}, [] {}, kStart);
  scheduler.apply(api::Pause{}, kStart + 3ms);
  EXPECT_EQ(scheduler.steps_due(kStart + 3ms), 3);
  scheduler.apply(api::Resume{}, kStart + 3ms);
  EXPECT_EQ(scheduler.steps_due(kStart + 3ms), 0);
  scheduler.apply(api::SetSpeed{4.0}, kStart + 3ms);
  EXPECT_EQ(scheduler.target_speed(), 4.0);
  EXPECT_EQ(scheduler.steps_due(kStart + 4ms), 4);
}

TEST(StepScheduler, ClientsPaceInShortBursts) {
  int wakes = 0;
  StepScheduler scheduler(
      {1ms, 1.0, VirtualTimeOptions{.grace = 0s}}, [&] { ++wakes; }, kStart);
  const auto client = scheduler.virtual_time()->join({.name = "grpc", .endpoint = 2}, [] {});
  ASSERT_TRUE(client);
  EXPECT_EQ(wakes, 1);
  EXPECT_TRUE(scheduler.update(kStart)) << "another client paces";
  EXPECT_FALSE(scheduler.update(kStart));
  EXPECT_TRUE(scheduler.is_paced());
  EXPECT_TRUE(scheduler.is_waiting());
  EXPECT_EQ(scheduler.endpoints(), std::vector<api::EndpointId>{2});
  EXPECT_FALSE(scheduler.target_speed());
  EXPECT_EQ(scheduler.next_turn(kStart), kStart + StepScheduler::kMaxSleep);
  scheduler.virtual_time()->request_until(*client, 7ms);
  (void)scheduler.update(kStart);
  EXPECT_FALSE(scheduler.is_waiting());
  EXPECT_EQ(scheduler.steps_due(kStart), 5);
  take_steps(scheduler, 5, kStart);
  (void)scheduler.update(kStart);
  EXPECT_EQ(scheduler.steps_due(kStart), 2);
}

TEST(StepScheduler, TheWallClockDoesNotCatchUpWithPacedTime) {
  StepScheduler scheduler(
      {1ms, 1.0, VirtualTimeOptions{.grace = 0s}}, [] {}, kStart);
  const auto client = scheduler.virtual_time()->join({.name = "grpc"}, [] {});
  (void)scheduler.update(kStart);
  scheduler.virtual_time()->leave(*client);
  (void)scheduler.update(kStart + 40ms);
  EXPECT_FALSE(scheduler.is_paced());
  EXPECT_EQ(scheduler.steps_due(kStart + 40ms), 0);
  EXPECT_EQ(scheduler.steps_due(kStart + 42ms), 2);
}

}  // namespace
}  // namespace aprsim::world
