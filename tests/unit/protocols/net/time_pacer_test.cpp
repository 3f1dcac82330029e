#include "protocols/net/time_pacer.hpp"

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <boost/asio/io_context.hpp>
#include <gtest/gtest.h>

namespace aprsim::protocols {
namespace {

using namespace std::chrono_literals;

/// Virtual time of one pacer, which the test lets pass.
class FakeTime final : public api::VirtualTime {
 public:
  [[nodiscard]] SimTime poll_period() const override { return 25ms; }
  [[nodiscard]] bool is_registered(const std::string& role) const override {
    return role == "modbus";
  }
  [[nodiscard]] std::optional<api::PacerId> join(api::PacerRole role,
                                                 std::function<void()> reached) override {
    if (role.name == "too many") return std::nullopt;
    reached_ = std::move(reached);
    calls.push_back("join " + role.name);
    return 7;
  }
  void request_until(api::PacerId pacer, SimTime span) override {
    calls.push_back("ask " + std::to_string(pacer) + " " + std::to_string(span / 1ms));
  }
  void finish(api::PacerId) override { calls.emplace_back("finish"); }
  void leave(api::PacerId) override { calls.emplace_back("leave"); }
  void exclude(api::PacerId) override { calls.emplace_back("exclude"); }

  /// The span that was asked for has passed.
  void pass() { reached_(); }

  std::vector<std::string> calls;

 private:
  std::function<void()> reached_;
};

class TimePacerTest : public ::testing::Test {
 protected:
  void run() {
    io_.restart();
    io_.run();
  }

  boost::asio::io_context io_;
  FakeTime time_;
  TimePacer pacer_{&time_, io_.get_executor()};
  int done_ = 0;
};

TEST_F(TimePacerTest, GoesOnInItsOwnThreadOnceTimeHasPassed) {
  pacer_.join({.name = "modbus"});
  pacer_.after(25ms, [this] { ++done_; });
  EXPECT_TRUE(pacer_.waiting());
  time_.pass();
  EXPECT_EQ(done_, 0) << "not before the executor runs it";
  run();
  EXPECT_EQ(done_, 1);
  EXPECT_FALSE(pacer_.waiting());
  EXPECT_EQ(time_.calls, (std::vector<std::string>{"join modbus", "ask 7 25"}));
}

TEST_F(TimePacerTest, JoinsOnce) {
  pacer_.join({.name = "modbus"});
  pacer_.join({.name = "modbus"});
  EXPECT_EQ(time_.calls, std::vector<std::string>{"join modbus"});
}

TEST_F(TimePacerTest, StaysOutWhereThereIsNoPlaceOrNoVirtualTime) {
  pacer_.join({.name = "too many"});
  EXPECT_FALSE(pacer_.joined());
  TimePacer wall(nullptr, io_.get_executor());
  wall.join({.name = "modbus"});
  EXPECT_FALSE(wall.joined());
  EXPECT_FALSE(wall.is_registered("modbus"));
  EXPECT_TRUE(pacer_.is_registered("modbus"));
}

TEST_F(TimePacerTest, NothingFollowsAfterCancel) {
  pacer_.join({.name = "modbus"});
  pacer_.after(1ms, [this] { ++done_; });
  pacer_.cancel();
  EXPECT_FALSE(pacer_.waiting());
  time_.pass();
  run();
  EXPECT_EQ(done_, 0);
  EXPECT_TRUE(pacer_.joined());
}

TEST_F(TimePacerTest, CallThatComesAfterLeavingFindsNothing) {
  pacer_.join({.name = "modbus"});
  pacer_.after(1ms, [this] { ++done_; });
  time_.pass();
  pacer_.leave();
  pacer_.join({.name = "modbus"});
  pacer_.after(1ms, [this] { done_ += 10; });
  run();
  EXPECT_EQ(done_, 0);
  time_.pass();
  run();
  EXPECT_EQ(done_, 10);
}

TEST_F(TimePacerTest, LeavesAtItsEnd) {
  {
    TimePacer other(&time_, io_.get_executor());
    other.join({.name = "modbus"});
  }
  pacer_.exclude();
  EXPECT_EQ(time_.calls, (std::vector<std::string>{"join modbus", "leave"}));
}

}  // namespace
}  // namespace aprsim::protocols
