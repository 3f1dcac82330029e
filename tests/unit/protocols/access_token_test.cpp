#include "protocols/access_token.hpp"

#include <string>

#include <gtest/gtest.h>

namespace aprsim::protocols {
namespace {

using namespace std::chrono_literals;
using Verdict = AccessToken::Verdict;

TEST(AccessToken, IsRightOnlyWhole) {
  AccessToken token("right-token");
  AccessToken::Clock::time_point now{};
  for (const char* guess : {"", "right", "right-tokem", "right-tokenright-token", "Right-token"}) {
    EXPECT_EQ(token.check("10.0.0.1", guess, now), Verdict::kWrong) << guess;
    now += 1h;
  }
  EXPECT_EQ(token.check("10.0.0.1", "right-token", now), Verdict::kRight);
}

TEST(AccessToken, LetsAnAddressFailOnlySoOften) {
  AccessToken token("right-token");
  AccessToken::Clock::time_point now{};
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(token.check("10.0.0.1", "guess", now), Verdict::kWrong);
  }
  EXPECT_EQ(token.check("10.0.0.1", "guess", now), Verdict::kTooManyAttempts);
  EXPECT_EQ(token.check("10.0.0.1", "right-token", now), Verdict::kTooManyAttempts)
      << "else the right one would show";
  EXPECT_EQ(token.check("10.0.0.2", "right-token", now), Verdict::kRight)
      << "others are not held up";
  now += 4s;
  EXPECT_EQ(token.check("10.0.0.1", "right-token", now), Verdict::kTooManyAttempts);
  now += 2s;
  EXPECT_EQ(token.check("10.0.0.1", "right-token", now), Verdict::kRight);
}

TEST(AccessToken, CountsNothingWhenItIsRight) {
  AccessToken token("right-token");
  const AccessToken::Clock::time_point now{};
  for (int i = 0; i < 1000; ++i) {
    ASSERT_EQ(token.check("10.0.0.1", "right-token", now), Verdict::kRight) << i;
  }
}

TEST(AccessToken, TakesAMachinesIPv6NetworkForOneAddress) {
  AccessToken token("right-token");
  const AccessToken::Clock::time_point now{};
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(token.check("2001:db8::" + std::to_string(i), "guess", now), Verdict::kWrong);
  }
  EXPECT_EQ(token.check("2001:db8::99", "guess", now), Verdict::kTooManyAttempts);
}

TEST(AccessToken, HoldsAlsoAgainstManyAddresses) {
  AccessToken token("right-token");
  AccessToken::Clock::time_point now{};
  int tried = 0;
  for (int i = 0; i < 20'000; ++i) {
    const std::string host = "10." + std::to_string(i / 65536) + "." +
                             std::to_string(i / 256 % 256) + "." + std::to_string(i % 256);
    if (token.check(host, "guess", now) == Verdict::kWrong) ++tried;
  }
  EXPECT_LT(tried, 5000) << "those beyond what is remembered share one limit";
  now += 1h;
  EXPECT_EQ(token.check("192.168.0.1", "right-token", now), Verdict::kRight);
}

}  // namespace
}  // namespace aprsim::protocols
