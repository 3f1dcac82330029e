#include "server/config/memory_shares.hpp"

#include <gtest/gtest.h>

namespace aprsim::server {
namespace {

constexpr std::uint64_t kMb = std::uint64_t{1} << 20U;

std::uint64_t sum(const MemoryShares& shares) {
  return shares.program + shares.clients + shares.journal_ring + 4 * shares.journal_queue +
         shares.journal_files + shares.history + shares.past_states + shares.saved_states;
}

Result<MemoryShares> shares_with(
    const std::vector<std::pair<std::string, std::string>>& overrides) {
  const auto config = load_config("", overrides);
  EXPECT_TRUE(config) << config.error().message;
  return memory_shares(*config);
}

TEST(MemoryShares, FitIntoTheirLimit) {
  for (const char* max_mb : {"192", "400", "401", "1000", "65536"}) {
    const auto shares = shares_with({{"memory.max_mb", max_mb}});
    ASSERT_TRUE(shares) << max_mb << ": " << shares.error().message;
    EXPECT_EQ(shares->total, std::stoull(max_mb) * kMb);
    EXPECT_LE(sum(*shares), shares->total) << max_mb;
    EXPECT_LE(shares->grpc + shares->backlogs + shares->answers + shares->transfers +
                  shares->pages + shares->documents + shares->crcl_tap + shares->modbus_tap,
              shares->clients)
        << max_mb;
    EXPECT_GE(shares->journal_ring, 16 * kMb) << max_mb;
    EXPECT_GE(shares->history, 16 * kMb) << max_mb;
  }
}

/// The default limit is below that of the compose file and the unit.
TEST(MemoryShares, OfTheDefaultLimitLeaveRoomInAContainerOf512MB) {
  const auto shares = shares_with({});
  ASSERT_TRUE(shares);
  EXPECT_EQ(shares->total, 400 * kMb);
}

TEST(MemoryShares, TakeTheSizesThatTheirKeysSet) {
  const auto shares = shares_with(
      {{"journal.memory_mb", "8"}, {"history.max_mb", "9"}, {"memory.saved_states_mb", "10"}});
  ASSERT_TRUE(shares);
  EXPECT_EQ(shares->journal_ring, 8 * kMb);
  EXPECT_EQ(shares->history, 9 * kMb);
  EXPECT_EQ(shares->saved_states, 10 * kMb);
  const auto none = shares_with({{"journal.memory_mb", "0"}});
  ASSERT_TRUE(none);
  EXPECT_EQ(none->journal_ring, 0U);
}

TEST(MemoryShares, NameWhatDoesNotFit) {
  const auto shares = shares_with({{"journal.memory_mb", "256"}, {"history.max_mb", "128"}});
  ASSERT_FALSE(shares);
  EXPECT_EQ(shares.error().field, "memory.max_mb");
  for (const char* word :
       {"memory.max_mb: 400 MB", "journal.memory_mb 256", "history.max_mb 128"}) {
    EXPECT_NE(shares.error().message.find(word), std::string::npos) << shares.error().message;
  }
}

}  // namespace
}  // namespace aprsim::server
