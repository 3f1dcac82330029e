#include "world/runtime/commands/command_queue.hpp"

#include <thread>

#include <gtest/gtest.h>

namespace aprsim::world {
namespace {

using namespace std::chrono_literals;

api::Command resume() { return {.endpoint = 7, .body = api::SimulationCommand{api::Resume{}}}; }
api::Command of(api::SimulationCommand command) {
  return {.endpoint = 7, .body = std::move(command)};
}
api::Command pause() { return {.endpoint = 7, .body = api::SimulationCommand{api::Pause{}}}; }

TEST(CommandQueue, NumbersCommandsInOrder) {
  CommandQueue queue(4);
  EXPECT_EQ(queue.push(pause()).value(), 1U);
  EXPECT_EQ(queue.push(pause()).value(), 2U);
  std::vector<QueuedCommand> out;
  queue.drain(out);
  ASSERT_EQ(out.size(), 2U);
  EXPECT_EQ(out[0].ticket, 1U);
  EXPECT_EQ(out[1].ticket, 2U);
  EXPECT_EQ(out[0].command.endpoint, 7U);
  queue.drain(out);
  EXPECT_TRUE(out.empty());
  EXPECT_EQ(queue.push(pause()).value(), 3U);
}

/// Every stop is taken however full the queue is, after what came before it.
TEST(CommandQueue, AFullQueueTakesStops) {
  CommandQueue queue(4);
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(queue.push(resume()));
  std::vector<api::Command> stops{pause()};
  for (const int robot : {0, 1}) {
    for (const auto kind :
         {api::StopKind::kNormal, api::StopKind::kFast, api::StopKind::kImmediate}) {
      stops.push_back({.body = api::RobotCommand{robot, api::StopMotion{kind}}});
    }
  }
  stops.push_back({.body = api::ConveyorCommand{.emergency_stop = true}});
  stops.push_back({.body = api::ConveyorCommand{.run = false}});
  stops.push_back({.body = api::ConveyorCommand{.run = false, .speed_m_s = 0.1}});
  api::Ticket last = 0;
  for (int again = 0; again < 1000; ++again) {
    for (const api::Command& stop : stops) {
      const auto ticket = queue.push(stop);
      ASSERT_TRUE(ticket) << ticket.error().message;
      EXPECT_GT(*ticket, last);
      last = *ticket;
    }
    EXPECT_FALSE(queue.push(resume()));
    EXPECT_FALSE(queue.push({.body = api::RobotCommand{0, api::InitRobot{}}}));
    EXPECT_FALSE(queue.push({.body = api::ConveyorCommand{.run = true, .emergency_stop = true}}));
  }
  std::vector<QueuedCommand> out;
  queue.drain(out);
  // One stop of the belt does what the last ones do together.
  ASSERT_EQ(out.size(), 4 + stops.size() - 2);
  EXPECT_EQ(std::get<api::ConveyorCommand>(out.back().command.body),
            (api::ConveyorCommand{.run = false, .speed_m_s = 0.1, .emergency_stop = true}));
  for (std::size_t i = 1; i < out.size(); ++i) EXPECT_GT(out[i].ticket, out[i - 1].ticket);
  EXPECT_EQ(out.back().ticket, last);
}

/// Settings that come with a stop make no two stops different enough to fill the queue.
TEST(CommandQueue, AFullQueueTakesStopsOfStreams) {
  CommandQueue queue(1);
  const auto push = [&](const api::TrajectoryAction& action) {
    return queue.push({1, api::TrajectoryCommand{0, action}});
  };
  // The endpoint's own places are full, too.
  while (push(api::AppendPoints{1})) {
  }
  EXPECT_TRUE(push(api::StopStream{1}));
  EXPECT_TRUE(push(api::StopStream{2}));
  EXPECT_TRUE(push(api::ReleaseMotion{1}));
  EXPECT_FALSE(push(api::ReleaseMotion{1, true}));
  EXPECT_FALSE(push(api::ClaimMotion{"a"}));
  const std::size_t before = queue.size();
  EXPECT_TRUE(push(api::StopStream{1}));
  EXPECT_TRUE(push(api::ReleaseMotion{1}));
  EXPECT_EQ(queue.size(), before) << "the same stops are merged";
}

TEST(CommandQueue, AStopOfTheBeltIsTakenBehindAFloodOfOthers) {
  CommandQueue queue(4);
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(queue.push(resume()));
  for (int i = 0; i < 5000; ++i) {
    const api::ConveyorCommand stop{.run = false, .forward = i % 2 == 0, .speed_m_s = 1e-5 * i};
    ASSERT_TRUE(queue.push({.endpoint = 1, .body = stop}));
  }
  ASSERT_TRUE(queue.push({.endpoint = 2, .body = api::ConveyorCommand{.emergency_stop = true}}));
  std::vector<QueuedCommand> out;
  queue.drain(out);
  ASSERT_EQ(out.size(), 5U);
  EXPECT_EQ(std::get<api::ConveyorCommand>(out.back().command.body),
            (api::ConveyorCommand{
                .run = false, .forward = false, .speed_m_s = 1e-5 * 4999, .emergency_stop = true}));
}

/// A command between two stops keeps both in their order.
TEST(CommandQueue, StopsAreNotMergedAcrossAnotherCommandOfTheBelt) {
  CommandQueue queue(2);
  const auto belt = [](api::ConveyorCommand command) {
    return api::Command{.endpoint = 1, .body = command};
  };
  ASSERT_TRUE(queue.push(belt({.run = false, .speed_m_s = 0.1})));
  ASSERT_TRUE(queue.push(belt({.run = true, .speed_m_s = 0.2})));
  ASSERT_TRUE(queue.push(belt({.emergency_stop = true})));
  std::vector<QueuedCommand> out;
  queue.drain(out);
  ASSERT_EQ(out.size(), 3U);
  EXPECT_EQ(std::get<api::ConveyorCommand>(out[2].command.body),
            api::ConveyorCommand{.emergency_stop = true});
}

TEST(CommandQueue, FullQueueRefusesAndDoesNotUseUpATicket) {
  CommandQueue queue(2);
  ASSERT_TRUE(queue.push(resume()));
  ASSERT_TRUE(queue.push(resume()));
  const auto refused = queue.push(resume());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kUnavailable);
  std::vector<QueuedCommand> out;
  queue.drain(out);
  EXPECT_EQ(queue.push(pause()).value(), 3U);
}

/// A flooding endpoint leaves room for every other endpoint, however many flood.
TEST(CommandQueue, EachEndpointHasPlacesOfItsOwn) {
  CommandQueue queue(1024);
  const auto from = [&](api::EndpointId endpoint) {
    return queue.push({endpoint, api::ConveyorCommand{.run = true}}).has_value();
  };
  const auto taken = [&](api::EndpointId endpoint) {
    int count = 0;
    while (from(endpoint)) ++count;
    return count;
  };
  for (int again = 0; again < 3; ++again) {
    EXPECT_EQ(taken(1), 1024);
    for (const api::EndpointId other : {2U, 3U, 16U, 40U}) EXPECT_EQ(taken(other), 64);
    for (int stop = 0; stop < 1000; ++stop) {
      const auto command = api::RobotCommand{stop % 2, api::StopMotion{}};
      ASSERT_TRUE(queue.push({static_cast<api::EndpointId>(stop % 5), command}));
    }
    EXPECT_FALSE(from(1));
    EXPECT_EQ(taken(41), 64);
    std::vector<QueuedCommand> out;
    queue.drain(out);
    EXPECT_EQ(out.size(), 1024U + 5 * 64 + 2);
    for (std::size_t i = 1; i < out.size(); ++i) EXPECT_GT(out[i].ticket, out[i - 1].ticket);
  }
}

// A stop comes after what was sent before it, and that must not be a hundred resets.
TEST(CommandQueue, FewWaitOfThoseThatTakeLong) {
  CommandQueue queue(100);
  int taken = 0;
  const auto fill = [&] {
    for (int i = 0; i < 10; ++i) {
      taken += queue.push(of(api::Reset{})).has_value();
      taken += queue.push(of(api::SaveState{"one"})).has_value();
      taken += queue.push(of(api::LoadState{"one"})).has_value();
    }
  };
  fill();
  EXPECT_EQ(taken, 4);
  const auto refused = queue.push(of(api::Reset{}));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kUnavailable);
  EXPECT_NE(refused.error().message.find("4 resets, saves and loads"), std::string::npos);
  EXPECT_TRUE(queue.push(pause()));
  EXPECT_TRUE(queue.push(resume()));
  std::vector<QueuedCommand> out;
  queue.drain(out);
  EXPECT_EQ(out.size(), 6U);
  fill();
  EXPECT_EQ(taken, 8);
}

TEST(CommandQueue, WaitEndsWhenFilledOrClosed) {
  CommandQueue queue(2);
  const std::uint64_t empty = queue.changes();
  std::jthread producer([&] { EXPECT_TRUE(queue.push(pause())); });
  queue.wait_until(empty, std::chrono::steady_clock::now() + 10s);
  std::vector<QueuedCommand> out;
  queue.drain(out);
  EXPECT_EQ(out.size(), 1U);
  std::jthread notifier([&] { queue.notify(); });
  queue.wait_until(empty + 1, std::chrono::steady_clock::now() + 10s);
  EXPECT_EQ(queue.changes(), empty + 2);
  std::jthread closer([&] { queue.close(); });
  queue.wait_until(empty + 2, std::chrono::steady_clock::now() + 10s);
  closer.join();
  EXPECT_FALSE(queue.push(pause()));
}

TEST(CommandQueue, TellsCommandsOfOthers) {
  CommandQueue queue(4);
  const std::vector<api::EndpointId> pacers{16, 17};
  api::Command command = pause();
  command.endpoint = 17;
  ASSERT_TRUE(queue.push(command));
  EXPECT_FALSE(queue.holds_other_than(pacers));
  command.endpoint = 2;
  ASSERT_TRUE(queue.push(command));
  EXPECT_TRUE(queue.holds_other_than(pacers));
}

TEST(CommandQueue, ManyProducersLoseNothing) {
  CommandQueue queue(10000);
  {
    std::vector<std::jthread> producers;
    for (int i = 0; i < 4; ++i) {
      producers.emplace_back([&] {
        for (int n = 0; n < 1000; ++n) EXPECT_TRUE(queue.push(pause()));
      });
    }
  }
  std::vector<QueuedCommand> out;
  queue.drain(out);
  ASSERT_EQ(out.size(), 4000U);
  for (std::size_t i = 0; i < out.size(); ++i) EXPECT_EQ(out[i].ticket, i + 1);
}

}  // namespace
}  // namespace aprsim::world
