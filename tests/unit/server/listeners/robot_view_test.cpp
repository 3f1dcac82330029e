#include "server/listeners/robot_view.hpp"

#include <algorithm>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/case_count.hpp"
#include "tests/support/fake_cell.hpp"

namespace aprsim::server {
namespace {

using test::FakeCell;

class RobotViewTest : public ::testing::Test {
 protected:
  /// The next snapshot is of a scene with these robots of the first cell, in this order.
  void change_scene(const std::vector<std::size_t>& robots) {
    auto other = std::make_shared<api::CellDescription>(*first_->cell);
    other->robots.clear();
    for (const std::size_t robot : robots) other->robots.push_back(first_->cell->robots[robot]);
    cell_.publish([&](api::Snapshot& next) {
      ++next.epoch;
      next.cell = other;
      next.robots.clear();
      for (const std::size_t robot : robots) next.robots.push_back(first_->robots[robot]);
    });
  }
  Result<api::Ticket> stop(int index) {
    return view_.submit({.endpoint = 17, .body = api::RobotCommand{index, api::StopMotion{}}});
  }

  FakeCell cell_;
  const api::SnapshotPtr first_ = cell_.latest();
  RobotView view_{cell_, cell_, first_, 1};  // of the motoman
};

TEST_F(RobotViewTest, ShowsTheLatestWhileTheRobotIsThere) {
  cell_.publish([](api::Snapshot&) {});
  EXPECT_EQ(view_.latest(), cell_.latest());
  change_scene({0, 1});
  EXPECT_EQ(view_.latest(), cell_.latest());
}

TEST_F(RobotViewTest, KeepsTheLastOneWithTheRobot) {
  change_scene({0});
  EXPECT_EQ(view_.latest(), first_);
  EXPECT_EQ(view_.latest()->robots.size(), 2U);
  const auto gone = stop(1);
  ASSERT_FALSE(gone);
  EXPECT_EQ(gone.error().code, ErrorCode::kUnavailable);
  EXPECT_EQ(gone.error().message, "the robot motoman has left the cell");
  change_scene({0, 1});
  EXPECT_EQ(view_.latest(), cell_.latest());
  EXPECT_TRUE(stop(1));
}

TEST_F(RobotViewTest, AnotherModelIsAnotherRobot) {
  auto other = std::make_shared<api::CellDescription>(*first_->cell);
  other->robots[1].model = "another";
  cell_.publish([&](api::Snapshot& next) { next.cell = other; });
  EXPECT_EQ(view_.latest(), first_);
  EXPECT_FALSE(stop(1));
}

TEST_F(RobotViewTest, CommandsReachTheRobotAtItsPresentIndex) {
  change_scene({1});
  EXPECT_EQ(view_.latest(), first_) << "the listener has another index";
  ASSERT_TRUE(stop(1));
  const api::Command sent = cell_.commands().back();
  EXPECT_EQ(std::get<api::RobotCommand>(sent.body).robot, 0);
  EXPECT_EQ(sent.cell, cell_.latest()->cell);
  EXPECT_EQ(sent.endpoint, 17U);
  view_.move_to(0, cell_.latest());
  EXPECT_EQ(view_.latest(), cell_.latest());
}

// A snapshot of the view has the robot at the listener's index, in any sequence of scenes.
TEST_F(RobotViewTest, TheIndexIsAlwaysThatOfTheRobot) {
  std::mt19937 random(48);
  int index = 1;
  for (int i = 0; i < test::case_count(2000); ++i) {
    std::vector<std::size_t> robots{0, 1, 0};
    robots.resize(random() % 4 % 3 + 1);
    std::ranges::shuffle(robots, random);
    change_scene(robots);
    if (random() % 3 == 0) {
      const auto& now = cell_.latest()->cell->robots;
      const auto found = std::ranges::find(now, "motoman", &api::RobotDescription::name);
      if (found != now.end()) {
        index = static_cast<int>(found - now.begin());
        view_.move_to(index, cell_.latest());
      }
    }
    const api::SnapshotPtr seen = view_.latest();
    const auto at = static_cast<std::size_t>(index);
    ASSERT_LT(at, seen->robots.size());
    ASSERT_EQ(seen->cell->robots[at].name, "motoman") << i;
    if (const auto ticket = stop(index)) {
      const auto sent = cell_.commands().back();
      const auto to = static_cast<std::size_t>(std::get<api::RobotCommand>(sent.body).robot);
      ASSERT_EQ(cell_.latest()->cell->robots.at(to).name, "motoman") << i;
    }
  }
}

}  // namespace
}  // namespace aprsim::server
