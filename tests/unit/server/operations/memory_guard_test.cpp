#include "server/operations/memory_guard.hpp"

#include <gtest/gtest.h>

namespace aprsim::server {
namespace {

using namespace std::chrono_literals;

constexpr std::uint64_t kLimit = 1000;

struct Process {
  std::uint64_t resident = 0;
  int relieved = 0;
  MemoryGuard guard{kLimit,
                    [this] {
                      ++relieved;
                      resident -= 100;
                    },
                    [this] { return resident; }};
  MemoryGuard::Clock::time_point now = MemoryGuard::Clock::now();

  int check_at(std::uint64_t bytes) {
    resident = bytes;
    now += 3s;
    guard.check(now);
    return relieved;
  }
};

TEST(MemoryGuard, DropsWhatIsKeptOnlyNearTheLimit) {
  Process process;
  EXPECT_EQ(process.check_at(900), 0);
  EXPECT_EQ(process.check_at(950), 1);
  EXPECT_EQ(process.check_at(700), 1);
  EXPECT_EQ(process.check_at(990), 2);
}

TEST(MemoryGuard, GivesWhatWasFreedTimeToShow) {
  Process process;
  EXPECT_EQ(process.check_at(990), 1);
  process.resident = 990;
  process.guard.check(process.now + 100ms);
  EXPECT_EQ(process.relieved, 1);
  process.guard.check(process.now + 2s);
  EXPECT_EQ(process.relieved, 2);
}

TEST(MemoryGuard, KnowsTheMemoryOfThisProcess) { EXPECT_GT(resident_bytes(), 1U << 20U); }

}  // namespace
}  // namespace aprsim::server
