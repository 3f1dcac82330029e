#include "protocols/record/wire_tap.hpp"

#include <gtest/gtest.h>

#include "tests/support/fake_cell.hpp"

namespace aprsim::protocols {
namespace {

using std::chrono::system_clock;

class WireTapTest : public ::testing::Test {
 protected:
  [[nodiscard]] std::vector<WireEventPtr> all(const WireTap& tap, bool with_polls = true) const {
    std::vector<WireEventPtr> events;
    (void)tap.read(1, with_polls, ~std::size_t{0}, events);
    return events;
  }
  static WireEvent command(const std::string& source, std::int64_t id, std::size_t bytes = 0) {
    return {.source = source,
            .from_client = true,
            .time = system_clock::now(),
            .id = id,
            .data = std::string(bytes, 'x')};
  }
  static WireEvent poll(std::int64_t id, std::size_t bytes = 0) {
    WireEvent event = command("crcl.fanuc", id, bytes);
    event.poll = true;
    return event;
  }

  test::FakeCell world;
};

TEST_F(WireTapTest, KeepsCommandsFromTheStartWithBothTimes) {
  WireTap tap(world);
  world.publish([](api::Snapshot& s) {
    s.epoch = 2;
    s.time = std::chrono::milliseconds(2500);
  });
  tap.record(command("crcl.fanuc", 7));
  const auto events = all(tap);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0]->id, 7);
  EXPECT_EQ(events[0]->number, 1u);
  EXPECT_DOUBLE_EQ(events[0]->sim_time_s, 2.5);
  EXPECT_EQ(events[0]->sim_epoch, 2u);
  EXPECT_EQ(all(tap).size(), 1u) << "reading takes nothing away";
}

TEST_F(WireTapTest, PollsAreKeptWhileWantedAndPushNoCommandOut) {
  WireTap tap(world);
  tap.record(command("crcl.fanuc", 1));
  tap.record(poll(0));
  EXPECT_EQ(all(tap).size(), 1u);
  tap.want_polls(true);
  for (std::size_t i = 0; i < WireTap::kMaxPolls + 10; ++i) tap.record(poll(-1, 10));
  EXPECT_EQ(all(tap).size(), 1 + WireTap::kMaxPolls);
  EXPECT_EQ(all(tap, false).size(), 1u);
  tap.want_polls(false);
  EXPECT_EQ(all(tap).size(), 1u);
  tap.want_polls(true);
  for (int i = 0; i < 1000; ++i) tap.record(poll(-1, WireTap::kMaxData));
  EXPECT_LE(all(tap).size(), WireTap::kMaxPollBytes / WireTap::kMaxData);
  EXPECT_EQ(all(tap).front()->id, 1);
}

TEST_F(WireTapTest, AFloodPushesOutItsOwnCommandsOnly) {
  WireTap tap(world, 100'000);
  for (int i = 0; i < 10; ++i) tap.record(command("crcl.motoman", i, 1000));
  for (int i = 0; i < 5000; ++i) tap.record(command("crcl.fanuc", 100 + i, 1000));
  int others = 0;
  std::size_t bytes = 0;
  for (const auto& event : all(tap)) {
    others += event->source == "crcl.motoman";
    bytes += event->data.size();
  }
  EXPECT_EQ(others, 10);
  EXPECT_LE(bytes, 100'000u);
  EXPECT_GT(bytes, 50'000u);
  EXPECT_EQ(all(tap).back()->id, 5099);
  EXPECT_EQ(tap.given_up(), 5010 - all(tap).size());
}

TEST_F(WireTapTest, OldCommandsGoOnceThereAreManyNewerOnes) {
  WireTap tap(world);
  for (int i = 0; i < 600; ++i) {
    WireEvent old = command("crcl.fanuc", i);
    old.time -= WireTap::kKeep + std::chrono::seconds(1);
    tap.record(std::move(old));
  }
  EXPECT_EQ(all(tap).size(), 600u) << "nothing newer: they are the latest";
  for (int i = 0; i < 10; ++i) tap.record(command("crcl.fanuc", 1000 + i));
  EXPECT_EQ(all(tap).size(), WireTap::kKeptAnyway);
  for (std::size_t i = 0; i < 2 * WireTap::kKeptAnyway; ++i)
    tap.record(command("crcl.fanuc", 2000));
  EXPECT_EQ(all(tap).size(), 2 * WireTap::kKeptAnyway + 10) << "within the time all are kept";
}

TEST_F(WireTapTest, LongDocumentsAreCutAndTextsMadeFit) {
  WireTap tap(world);
  WireEvent event = command("crcl.fanuc", 1, WireTap::kMaxData + 100);
  event.type = "Bad\xff";
  event.state = std::string(5000, 'e');
  tap.record(std::move(event));
  const auto events = all(tap);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0]->data.size(), WireTap::kMaxData);
  EXPECT_EQ(events[0]->data_bytes, WireTap::kMaxData + 100);
  EXPECT_EQ(events[0]->type, "Bad\\xff");
  EXPECT_LT(events[0]->state.size(), 500u);
}

TEST_F(WireTapTest, IsReadInPiecesWithoutLossOrRepetition) {
  WireTap tap(world);
  tap.want_polls(true);
  for (int i = 1; i <= 300; ++i) {
    tap.record(i % 3 == 0 ? poll(i, 100) : command(i % 3 == 1 ? "a" : "b", i, 100));
  }
  std::int64_t last = 0;
  std::uint64_t from = 1;
  for (int turns = 0; last < 300; ++turns) {
    ASSERT_LT(turns, 300);
    std::vector<WireEventPtr> events;
    from = tap.read(from, true, 2000, events);
    ASSERT_FALSE(events.empty());
    ASSERT_LT(events.size(), 20u);
    for (const auto& event : events) EXPECT_EQ(event->id, ++last);
  }
  std::vector<WireEventPtr> none;
  EXPECT_EQ(tap.read(from, true, 2000, none), 301u);
  EXPECT_TRUE(none.empty());
}

}  // namespace
}  // namespace aprsim::protocols
