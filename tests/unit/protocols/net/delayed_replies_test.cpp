#include "protocols/net/delayed_replies.hpp"

#include <chrono>
#include <memory>
#include <vector>

#include <boost/asio/io_context.hpp>
#include <gtest/gtest.h>

namespace aprsim::protocols {
namespace {

using namespace std::chrono_literals;

class DelayedRepliesTest : public ::testing::Test {
 protected:
  boost::asio::io_context io_;
  std::vector<int> sent_;
  int rounds_ = 0;
  bool closes_ = false;  // when it sends
  DelayedReplies<int> delayed_{io_.get_executor(),
                               {[this](int reply) {
                                  sent_.push_back(reply);
                                  if (closes_) delayed_.close();
                                },
                                [this] { ++rounds_; }}};
  std::shared_ptr<int> owner_ = std::make_shared<int>();
};

TEST_F(DelayedRepliesTest, OnlyADelayedReplyWaitsWhereNoneWaits) {
  EXPECT_FALSE(delayed_.must_wait(0ns));
  EXPECT_TRUE(delayed_.must_wait(1ns));
}

TEST_F(DelayedRepliesTest, LaterReplyWithoutDelayKeepsItsPlace) {
  delayed_.add(1, 10, 2ms, owner_);
  EXPECT_TRUE(delayed_.must_wait(0ns));
  delayed_.add(2, 5, 0ns, owner_);
  EXPECT_EQ(delayed_.bytes(), 15U);
  io_.run();
  EXPECT_EQ(sent_, (std::vector<int>{1, 2}));
  EXPECT_EQ(delayed_.bytes(), 0U);
  EXPECT_TRUE(delayed_.empty());
  EXPECT_EQ(rounds_, 1);
}

TEST_F(DelayedRepliesTest, NothingFollowsAClose) {
  closes_ = true;
  delayed_.add(1, 1, 1ms, owner_);
  delayed_.add(2, 1, 0ns, owner_);
  io_.run();
  EXPECT_EQ(sent_, std::vector<int>{1});
  EXPECT_EQ(rounds_, 0);
}

TEST_F(DelayedRepliesTest, OwnerLivesAsLongAsAReplyWaits) {
  const std::weak_ptr<int> alive = owner_;
  delayed_.add(1, 1, 1ms, std::move(owner_));
  EXPECT_FALSE(alive.expired());
  io_.run();
  EXPECT_TRUE(alive.expired());
}

}  // namespace
}  // namespace aprsim::protocols
