#include "world/command_queue.hpp"

#include <thread>

#include <gtest/gtest.h>

namespace aprsim::world {
namespace {

using namespace std::chrono_literals;

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

TEST(CommandQueue, FullQueueRefusesAndDoesNotUseUpATicket) {
  CommandQueue queue(2);
  ASSERT_TRUE(queue.push(pause()));
  ASSERT_TRUE(queue.push(pause()));
  const auto refused = queue.push(pause());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kUnavailable);
  std::vector<QueuedCommand> out;
  queue.drain(out);
  EXPECT_EQ(queue.push(pause()).value(), 3U);
}

TEST(CommandQueue, WaitEndsWhenFilledOrClosed) {
  CommandQueue queue(2);
  std::jthread producer([&] { EXPECT_TRUE(queue.push(pause())); });
  queue.wait_until(std::chrono::steady_clock::now() + 10s);
  std::vector<QueuedCommand> out;
  queue.drain(out);
  EXPECT_EQ(out.size(), 1U);
  std::jthread closer([&] { queue.close(); });
  queue.wait_until(std::chrono::steady_clock::now() + 10s);
  closer.join();
  EXPECT_FALSE(queue.push(pause()));
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
