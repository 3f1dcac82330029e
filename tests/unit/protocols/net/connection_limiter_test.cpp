#include "protocols/net/connection_limiter.hpp"

#include <map>
#include <string>

#include <gtest/gtest.h>

namespace aprsim::protocols {
namespace {

using namespace std::chrono_literals;
using Slot = ConnectionLimiter::Slot;

TEST(ClientAddress, IsWhatOneMachineHas) {
  EXPECT_EQ(client_address("10.1.2.3"), "10.1.2.3");
  EXPECT_EQ(client_address("::ffff:10.1.2.3"), "10.1.2.3");
  EXPECT_EQ(client_address("::1"), "::1");
  EXPECT_EQ(client_address("2001:db8::1"), client_address("2001:db8::ffff:2"));
  EXPECT_NE(client_address("2001:db8::1"), client_address("2001:db8:0:1::1"));
  EXPECT_EQ(client_address("fe80::1%eth0"), client_address("fe80::2%eth0"));
  EXPECT_EQ(host_of("10.1.2.3:80"), "10.1.2.3");
  EXPECT_EQ(host_of("[2001:db8::1]:80"), "2001:db8::1");
}

/// Connections by name; "A1" is the first of the address 10.0.0.A.
class ConnectionLimiterTest : public testing::Test {
 protected:
  void limit(ConnectionLimits limits) { limiter_ = ConnectionLimiter::create(limits); }
  /// Whether there was a slot for it.
  bool take(const std::string& name) {
    auto slot = limiter_->take("10.0.0." + std::to_string(name[0]), now_);
    if (!slot) {
      refusal_ = slot.error().message;
      return false;
    }
    slot->on_evict([this, name] { ended_ += name + " "; });
    held_.insert_or_assign(name, std::move(*slot));
    return true;
  }
  void use(const std::string& name) { held_.at(name).used(now_); }
  bool take_and_use(const std::string& name) {
    if (!take(name)) return false;
    use(name);
    return true;
  }

  ConnectionLimiter::Clock::time_point now_{};
  std::shared_ptr<ConnectionLimiter> limiter_;
  std::map<std::string, Slot> held_;
  std::string ended_, refusal_;
};

TEST_F(ConnectionLimiterTest, ComeBackWhenTheyAreLeft) {
  limit({.at_once = 2});
  EXPECT_TRUE(take_and_use("A1") && take_and_use("A2"));
  EXPECT_FALSE(take("A3"));
  EXPECT_EQ(refusal_, "2 connections open, the limit");
  held_.at("A1").leave();
  held_.at("A1").leave();
  EXPECT_EQ(limiter_->open(), 1U);
  EXPECT_TRUE(take("A3"));
  held_.clear();
  EXPECT_EQ(limiter_->open(), 0U);
}

TEST_F(ConnectionLimiterTest, OneAddressHasItsShareAndReplacesOnlyItsOwnIdleOnes) {
  limit({.at_once = 10, .per_address = 2, .yield_after = 60s});
  EXPECT_TRUE(take("B1"));
  EXPECT_TRUE(take_and_use("A1") && take_and_use("A2"));
  EXPECT_FALSE(take("A3"));
  EXPECT_EQ(refusal_, "2 connections open from its address, the limit");
  now_ += 60s;
  use("A1");
  EXPECT_TRUE(take("A3"));
  EXPECT_EQ(ended_, "A2 ");
}

TEST_F(ConnectionLimiterTest, OnesThatRestAreIdleUntilTheyAreUsed) {
  limit({.at_once = 2, .yield_after = 60s});
  EXPECT_TRUE(take_and_use("A1") && take_and_use("A2"));
  held_.at("A1").rest();
  held_.at("A2").rest();
  use("A1");
  EXPECT_TRUE(take_and_use("A3"));
  EXPECT_EQ(ended_, "A2 ");
  EXPECT_FALSE(take("A4"));
}

TEST_F(ConnectionLimiterTest, ThisMachineMayHaveThemAll) {
  limit({.at_once = 4, .per_address = 1});
  std::vector<Slot> all;
  for (int i = 0; i < 4; ++i) {
    auto slot = limiter_->take("127.0.0.1", now_);
    ASSERT_TRUE(slot);
    slot->used(now_);
    all.push_back(std::move(*slot));
  }
  EXPECT_FALSE(limiter_->take("127.0.0.1", now_));
  EXPECT_TRUE(limiter_->take("10.0.0.1", now_)) << "the one that is kept";
}

TEST_F(ConnectionLimiterTest, AreGivenUpByThoseThatNeverAskedThenByTheLongestIdle) {
  limit({.at_once = 3, .yield_after = 10s});
  EXPECT_TRUE(take_and_use("A1"));
  now_ += 1s;
  EXPECT_TRUE(take_and_use("A2"));
  now_ += 10s;
  EXPECT_TRUE(take("A3"));
  EXPECT_TRUE(take_and_use("A4"));
  EXPECT_EQ(ended_, "A3 ");
  EXPECT_TRUE(take_and_use("A5"));
  EXPECT_EQ(ended_, "A3 A1 ");
  use("A2");
  EXPECT_FALSE(take("A6")) << "none is idle";
}

TEST_F(ConnectionLimiterTest, AreNotTakenFromWhoHasFewer) {
  limit({.at_once = 3});
  EXPECT_TRUE(take("B1"));  // idle from the beginning, but the only one of its address
  EXPECT_TRUE(take_and_use("A1") && take_and_use("A2"));
  EXPECT_FALSE(take("A3"));
  EXPECT_EQ(ended_, "");
}

TEST_F(ConnectionLimiterTest, NewcomersNeverFindTheTableFullOfOthers) {
  limit({.at_once = 3, .per_address = 3});
  EXPECT_TRUE(take_and_use("A1") && take_and_use("A2") && take_and_use("B1"));
  EXPECT_TRUE(take_and_use("C1")) << "the one that is kept";
  EXPECT_EQ(ended_, "");
  EXPECT_TRUE(take_and_use("D1"));
  EXPECT_EQ(ended_, "A1 ") << "of the address that has most";
  // Every address has one now: idle ones go, busy ones stay.
  EXPECT_FALSE(take("E1"));
  now_ += 60s;
  use("A2");
  EXPECT_TRUE(take_and_use("E1"));
  EXPECT_EQ(ended_, "A1 B1 ");
  EXPECT_EQ(limiter_->open(), 4U);
}

TEST_F(ConnectionLimiterTest, KeptConnectionIsNeverIdle) {
  limit({.at_once = 1, .yield_after = 0s});
  EXPECT_TRUE(take("A1"));
  held_.at("A1").keep();
  EXPECT_FALSE(take("A2"));
  EXPECT_TRUE(take("B1"));
}

TEST_F(ConnectionLimiterTest, OutliveTheListener) {
  limit({});
  EXPECT_TRUE(take("A1"));
  limiter_.reset();
  use("A1");
  held_.clear();
}

}  // namespace
}  // namespace aprsim::protocols
