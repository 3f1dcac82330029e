// The events that are kept, and who reads them.

#include "world/runtime/publish/event_log.hpp"

#include <malloc.h>
#include <random>
#include <string>
#include <thread>
#include <tuple>

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

/// A daemon's memory would grow for most of an hour until the log is full.
TEST(EventLog, TakesNoMoreMemoryHoweverManyEventsCome) {
  EventLog log;
  const auto fill = [&](std::uint64_t first) {
    for (std::uint64_t i = first; i < first + 10'000; ++i) {
      log.add({std::make_shared<const api::CellEvent>(
          api::CellEvent{.sequence = i,
                         .names = {"motoman", "a_gear_with_a_long_name_" + std::to_string(i)},
                         .text = "touched a surface which has quite a long name, too",
                         .number = i})});
    }
  };
  fill(1);
  const std::size_t before = log.memory(), heap = ::mallinfo2().uordblks + ::mallinfo2().hblkhd;
  fill(10'001);
  EXPECT_EQ(log.memory(), before);
  EXPECT_LE(::mallinfo2().uordblks + ::mallinfo2().hblkhd, heap + 4096);
  const auto batch = log.after(19'998, 10);
  ASSERT_EQ(batch.events.size(), 2U);
  EXPECT_EQ(batch.events[1]->names[1], "a_gear_with_a_long_name_20000");
  EXPECT_EQ(batch.latest - batch.oldest + 1, api::kKeptEvents);
}

/// The log keeps the latest events unchanged, in any sequence of sizes.
TEST(EventLog, KeepsTheLatestOfEventsOfAnySize) {
  EventLog log(300);
  std::mt19937 random(1);
  std::vector<api::CellEvent> all;
  for (std::uint64_t i = 1; i <= 5000; ++i) {
    api::CellEvent event{.sequence = i,
                         .epoch = i / 100,
                         .step = 7 * i,
                         .time = std::chrono::milliseconds(i),
                         .kind = static_cast<api::CellEventKind>(i % api::kCellEventKinds),
                         .names = std::vector<std::string>(random() % 4, std::string(i % 50, 'n')),
                         .text = std::string(random() % (random() % 9 == 0 ? 5000 : 60), 't'),
                         .robot = static_cast<int>(i % 3) - 1,
                         .number = 3 * i};
    log.add({std::make_shared<const api::CellEvent>(event)});
    all.push_back(std::move(event));
    const auto batch = log.after(0, 256);
    ASSERT_EQ(batch.latest, i);
    std::uint64_t expected = batch.oldest;
    for (const auto& kept : batch.events) {
      const api::CellEvent& came = all[kept->sequence - 1];
      ASSERT_EQ(kept->sequence, expected++);
      ASSERT_EQ(kept->names, came.names);
      ASSERT_EQ(kept->text, came.text);
      ASSERT_EQ(
          std::tuple(kept->epoch, kept->step, kept->time, kept->kind, kept->robot, kept->number),
          std::tuple(came.epoch, came.step, came.time, came.kind, came.robot, came.number));
    }
  }
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
