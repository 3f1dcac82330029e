#include "world/base/rate_limit.hpp"

#include <gtest/gtest.h>

namespace aprsim::protocols {
namespace {

using namespace std::chrono_literals;

int admitted(RateLimit& limit, RateLimit::Clock::time_point now, int tries) {
  int count = 0;
  for (int i = 0; i < tries; ++i) count += limit.admit(now) ? 1 : 0;
  return count;
}

TEST(RateLimit, AdmitsASecondsWorthAtOnceAndThenTheRate) {
  RateLimit limit(10);
  const auto begin = RateLimit::Clock::now();
  EXPECT_EQ(admitted(limit, begin, 100), 10);
  EXPECT_EQ(admitted(limit, begin + 50ms, 100), 0);
  EXPECT_EQ(admitted(limit, begin + 150ms, 100), 1);
  EXPECT_EQ(admitted(limit, begin + 1150ms, 100), 10);
  EXPECT_EQ(admitted(limit, begin + 1h, 100), 10) << "no hoarding";
}

TEST(RateLimit, OverALongTimeItIsTheRate) {
  RateLimit limit(100);
  const auto begin = RateLimit::Clock::now();
  int count = 0;
  for (int ms = 0; ms <= 10000; ++ms) count += admitted(limit, begin + ms * 1ms, 3);
  EXPECT_NEAR(count, 1100, 1);
}

TEST(RateLimit, ZeroIsNoLimit) {
  RateLimit limit(0);
  EXPECT_EQ(admitted(limit, RateLimit::Clock::now(), 10000), 10000);
}

}  // namespace
}  // namespace aprsim::protocols
