// The tool changer by itself: when it switches, what it takes, what it defers.

#include "world/robot/controller/tool_change_sequence.hpp"

#include <gtest/gtest.h>

namespace aprsim::robot {
namespace {

TEST(ToolChangeSequence, WaitsForRestAndThenForTheLock) {
  ToolChangeSequence changer(0);
  EXPECT_FALSE(changer.busy());
  changer.begin(true, 2);
  EXPECT_TRUE(changer.busy());
  EXPECT_FALSE(changer.step(false, -1));
  EXPECT_FALSE(changer.step(false, -1));
  // The valve switches; from there on the arm may move.
  EXPECT_FALSE(changer.step(true, -1));
  EXPECT_FALSE(changer.step(false, -1));
  EXPECT_EQ(changer.tool(), 0);
  EXPECT_TRUE(changer.step(false, -1));
  EXPECT_EQ(changer.tool(), -1);
  EXPECT_FALSE(changer.busy());
  EXPECT_FALSE(changer.step(true, -1));
}

TEST(ToolChangeSequence, AClosingLockTakesTheToolAtTheFlange) {
  ToolChangeSequence changer(-1);
  changer.begin(false, 0);
  EXPECT_TRUE(changer.step(true, 3));
  EXPECT_EQ(changer.tool(), 3);
  EXPECT_FALSE(changer.closed_on_nothing());
  // It keeps the tool that it has.
  changer.begin(false, 0);
  EXPECT_TRUE(changer.step(true, 1));
  EXPECT_EQ(changer.tool(), 3);
}

TEST(ToolChangeSequence, AClosingLockMayTakeNothing) {
  ToolChangeSequence changer(-1);
  changer.begin(false, 0);
  EXPECT_TRUE(changer.step(true, -1));
  EXPECT_EQ(changer.tool(), -1);
  EXPECT_TRUE(changer.closed_on_nothing());
  changer.begin(true, 0);
  EXPECT_TRUE(changer.step(true, -1));
  EXPECT_FALSE(changer.closed_on_nothing());
}

TEST(ToolChangeSequence, ACancelledChangeGoesOnOnceTheValveIsSwitched) {
  ToolChangeSequence changer(0);
  changer.begin(true, 1);
  ASSERT_TRUE(changer.defer(1, api::Dwell{}));
  changer.cancel();
  EXPECT_FALSE(changer.busy());
  EXPECT_TRUE(changer.deferred().empty());
  changer.begin(true, 1);
  EXPECT_FALSE(changer.step(true, -1));
  changer.cancel();
  EXPECT_TRUE(changer.busy());
  EXPECT_TRUE(changer.step(true, -1));
  EXPECT_EQ(changer.tool(), -1);
}

TEST(ToolChangeSequence, DefersCommandsInTheirOrderUpToALimit) {
  ToolChangeSequence changer(0);
  for (api::Ticket ticket = 1; ticket <= ToolChangeSequence::kMaxDeferred; ++ticket) {
    EXPECT_TRUE(changer.defer(ticket, api::SetGripper{0.5}));
  }
  EXPECT_FALSE(changer.defer(99, api::SetGripper{0.5}));
  for (api::Ticket ticket = 1; ticket <= ToolChangeSequence::kMaxDeferred; ++ticket) {
    EXPECT_EQ(changer.take_deferred().ticket, ticket);
  }
  EXPECT_TRUE(changer.deferred().empty());
}

TEST(ToolChangeSequence, StopsAndInitializationPrecedeIt) {
  EXPECT_TRUE(precedes_tool_change(api::InitRobot{}));
  EXPECT_TRUE(precedes_tool_change(api::EndProgram{}));
  EXPECT_TRUE(precedes_tool_change(api::StopMotion{}));
  EXPECT_FALSE(precedes_tool_change(api::MoveTo{}));
  EXPECT_FALSE(precedes_tool_change(api::SetToolChanger{true}));
}

}  // namespace
}  // namespace aprsim::robot
