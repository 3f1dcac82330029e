// The events that are kept, and who reads them.

#include "world/runtime/publish/event_log.hpp"

#include <thread>

#include <gtest/gtest.h>

namespace aprsim::world {
namespace {

using namespace std::chrono_literals;

std::vector<api::CellEventPtr> numbered(std::uint64_t from, std::uint64_t to) {
  std::vector<api::CellEventPtr> events;
  for (; from <= to; ++from) {
    events.push_back(std::make_shared<const api::CellEvent>(api::CellEvent{.sequence = from}));
  }
  return events;
}

TEST(EventLog, GivesWhatComesAfterANumber) {
  EventLog log(10);
  EXPECT_EQ(log.after(0, 5).latest, 0u);
  log.add(numbered(1, 7));
  const auto batch = log.after(3, 2);
  ASSERT_EQ(batch.events.size(), 2u);
  EXPECT_EQ(batch.events[0]->sequence, 4u);
  EXPECT_EQ(batch.oldest, 1u);
  EXPECT_EQ(batch.latest, 7u);
  EXPECT_TRUE(log.after(7, 5).events.empty());
  EXPECT_TRUE(log.after(99, 5).events.empty());
}

TEST(EventLog, LetsTheOldestGo) {
  EventLog log(10);
  log.add(numbered(1, 25));
  const auto batch = log.after(3, 100);
  EXPECT_EQ(batch.oldest, 16u);
  ASSERT_EQ(batch.events.size(), 10u);
  EXPECT_EQ(batch.events.front()->sequence, 16u);
  EXPECT_EQ(log.after(20, 100).events.front()->sequence, 21u);
}

TEST(EventLog, WakesWhoWaits) {
  EventLog log(10);
  log.add(numbered(1, 2));
  std::jthread adder([&] { log.add(numbered(3, 3)); });
  log.wait_after(2, std::chrono::steady_clock::now() + 20s);
  EXPECT_EQ(log.after(2, 1).latest, 3u);
  const auto before = std::chrono::steady_clock::now();
  log.wait_after(3, before + 1ms);
  EXPECT_GE(std::chrono::steady_clock::now(), before + 1ms);
}

}  // namespace
}  // namespace aprsim::world
