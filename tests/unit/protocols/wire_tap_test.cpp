#include "protocols/wire_tap.hpp"

#include <gtest/gtest.h>

namespace aprsim::protocols {
namespace {

TEST(WireTap, GivesTheOldestEventsUp) {
  WireTap tap;
  tap.watch(true);
  for (std::size_t i = 0; i < WireTap::kMaxEvents + 10; ++i) {
    tap.note({.id = static_cast<std::int64_t>(i)});
  }
  std::vector<WireEvent> events;
  EXPECT_EQ(tap.fetch(5, events), 10u);
  ASSERT_EQ(events.size(), 5u);
  EXPECT_EQ(events.front().id, 10);
  EXPECT_EQ(tap.fetch(1, events), 0u);
}

TEST(WireTap, IsBoundedInBytes) {
  WireTap tap;
  tap.watch(true);
  for (int i = 0; i < 9; ++i) tap.note({.id = i, .data = std::string(std::size_t{1} << 20, 'x')});
  std::vector<WireEvent> events;
  EXPECT_EQ(tap.fetch(100, events), 5u);
  EXPECT_EQ(events.size(), 4u);
}

TEST(WireTap, ForgetsWhenNobodyWatches) {
  WireTap tap;
  EXPECT_FALSE(tap.watched());
  tap.watch(true);
  tap.note({.id = 1});
  tap.watch(false);
  tap.watch(true);
  std::vector<WireEvent> events;
  EXPECT_EQ(tap.fetch(100, events), 0u);
  EXPECT_TRUE(events.empty());
}

}  // namespace
}  // namespace aprsim::protocols
