// Guarded actions in the default cell, in stepped time: what the guards see is the contact itself.

#include <algorithm>
#include <array>

#include <gtest/gtest.h>

#include "tests/support/pick_place.hpp"
#include "world/api/snapshot/signal_value.hpp"

namespace aprsim::test {
namespace {

using api::GuardLimit;
using api::SignalKind;

const char* const kGuardedGear = "part_large_gear_1";

api::Guard guard(api::Signal signal, GuardLimit limit, double value) {
  api::Guard out;
  out.signal = signal;
  out.limit = limit;
  out.value = value;
  out.recheck = SimTime::zero();
  out.label = "test";
  return out;
}

/// The Fanuc with closed fingers over a gear's peg, ready to come down on it.
class OverAGear : public testing::Test {
 protected:
  OverAGear() : cell_(load_scene("aprs")) {
    const auto& robot = cell_.world.description()->robots[0];
    X_RW_ = (robot.X_WB.isometry() * robot.X_BR.isometry()).inverse();
    peg_W_ = cell_.X_WB(kGuardedGear) *
             Eigen::Vector3d(0, 0,
                             cell_.world.description()->bodies[cell_.body(kGuardedGear)].peg_top_m);
    cell_.act(0, api::InitRobot{});
    cell_.act(0, api::SetGripper{0});
    cell_.act(0, to(0.02));
    cell_.act(0, api::SetMotionLimit{api::MotionLimit::kTransSpeed, false, 0.02});
  }

  /// Straight to so far above the top of the peg.
  api::MoveTo to(double height_m) const {
    api::MoveTo move;
    move.X_RT = Pose::from(X_RW_ * tool_down(peg_W_ + Eigen::Vector3d(0, 0, height_m), 0));
    move.straight = height_m < 0.01;
    return move;
  }
  [[nodiscard]] double height() const { return robot().X_WT.p.z() - peg_W_.z(); }
  [[nodiscard]] const api::RobotSnapshot& robot() const { return cell_.now.robots[0]; }

  CellScript cell_;
  Eigen::Isometry3d X_RW_;
  Eigen::Vector3d peg_W_;
};

TEST_F(OverAGear, AMoveEndsAtTheTouch) {
  double most = 0;
  cell_.each_step = [&] { most = std::max(most, robot().force_T_R.norm()); };
  cell_.act(0, to(-0.02), 30, {guard({SignalKind::kForceR, 2}, GuardLimit::kIncreased, 2)});
  EXPECT_EQ(robot().action.state, api::ActionState::kDone);
  EXPECT_EQ(robot().action.description.substr(0, 24), "Guard test triggered at ");
  EXPECT_FALSE(robot().moving);
  EXPECT_NEAR(height(), 0, 1e-3);
  const api::GuardsSnapshot& guards = robot().guards;
  EXPECT_EQ(guards.triggers, 1U);
  EXPECT_EQ(guards.count, 1U);
  EXPECT_GT(guards.guards[0].checks, 100U);
  EXPECT_GT(guards.trigger_value, 2);
  EXPECT_GT(guards.stop_time, SimTime::zero());
  EXPECT_LT(guards.stop_time, std::chrono::milliseconds(100));
  EXPECT_LT(guards.trigger_value, most + 1e-9);
  EXPECT_FALSE(robot().protective_stop);
}

TEST_F(OverAGear, AGuardStaysWithItsMotionWhileAnotherCommandRunsBesideIt) {
  constexpr api::Ticket kMove = 1000;
  cell_.world.apply(
      kMove, api::RobotCommand{
                 0, to(-0.02), {guard({SignalKind::kForceR, 2}, GuardLimit::kIncreased, 2)}});
  cell_.advance(50);
  cell_.act(0, api::Dwell{std::chrono::seconds(5)});
  EXPECT_FALSE(robot().moving);
  EXPECT_NEAR(height(), 0, 1e-3);
  EXPECT_EQ(robot().guards.ticket, kMove);
  EXPECT_EQ(robot().guards.triggers, 1U);
  EXPECT_FALSE(robot().protective_stop);
  EXPECT_EQ(robot().action.description, "");
}

TEST_F(OverAGear, WithoutAGuardTheRobotStopsToProtectItself) {
  EXPECT_THROW(cell_.act(0, to(-0.02)), std::runtime_error);
  EXPECT_TRUE(robot().protective_stop);
}

TEST_F(OverAGear, InitializingAtOnceWaitsUntilTheArmHasBackedOff) {
  EXPECT_THROW(cell_.act(0, to(-0.02)), std::runtime_error);
  EXPECT_TRUE(robot().moving);
  EXPECT_LT(height(), 0);
  cell_.act(0, api::InitRobot{});
  EXPECT_GT(height(), 2e-3);
  EXPECT_FALSE(robot().moving);
  cell_.act(0, to(0.02));
  EXPECT_NEAR(height(), 0.02, 1e-6);
  EXPECT_FALSE(robot().protective_stop);
}

TEST_F(OverAGear, TheToolsOwnAxesSeeItTheOtherWayRound) {
  cell_.act(0, to(-0.02), 30, {guard({SignalKind::kForceT, 2}, GuardLimit::kDecreased, 2)});
  EXPECT_LT(robot().guards.trigger_value, -2);
  EXPECT_NEAR(height(), 0, 1e-3);
}

TEST_F(OverAGear, ATriggerMayBeAnError) {
  api::Guard one = guard({SignalKind::kForceR, 2}, GuardLimit::kOverMax, 2);
  one.error_on_trigger = true;
  try {
    cell_.act(0, to(-0.02), 30, {one});
    FAIL() << "no error";
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(std::string(error.what()).substr(0, 24), "Guard test triggered at ");
  }
  EXPECT_FALSE(robot().protective_stop);
  cell_.advance(200);
  EXPECT_FALSE(robot().moving);
  cell_.act(0, api::InitRobot{});
  cell_.act(0, to(0.02));
}

TEST_F(OverAGear, AMissingTriggerMayBeAnError) {
  api::Guard one = guard({SignalKind::kForceR, 2}, GuardLimit::kOverMax, 2);
  one.require_trigger = true;
  try {
    cell_.act(0, to(0.01), 30, {one});
    FAIL() << "no error";
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(std::string(error.what()),
              "Guard test: required trigger not seen, limit 2; send InitCanon to go on");
  }
  EXPECT_NEAR(height(), 0.01, 1e-6);
  cell_.act(0, api::InitRobot{});
  cell_.act(0, to(-0.02), 30, {one});
  EXPECT_EQ(robot().guards.triggers, 1U);
}

TEST_F(OverAGear, ASettingLeavesTheGuardOfTheMotionAlone) {
  bool set = false;
  cell_.each_step = [&] {
    if (set || height() > 0.008) return;
    set = true;
    api::RobotCommand command;
    command.action = api::SetMotionLimit{api::MotionLimit::kTransSpeed, false, 0.5};
    cell_.world.apply(1000, command);
  };
  try {
    cell_.act(0, to(-0.02), 3, {guard({SignalKind::kForceR, 2}, GuardLimit::kOverMax, 2)});
  } catch (const std::runtime_error&) {
    // The setting has taken the move's place in the report.
  }
  EXPECT_TRUE(set);
  EXPECT_EQ(robot().guards.triggers, 1U);
  EXPECT_NEAR(height(), 0, 1e-3);
  EXPECT_FALSE(robot().protective_stop);
}

TEST_F(OverAGear, TheSameRunGivesTheSameBits) {
  CellScript other(load_scene("aprs"));
  std::array<api::GuardsSnapshot, 2> seen;
  std::size_t i = 0;
  for (CellScript* cell : {&cell_, &other}) {
    if (cell == &other) {
      cell->act(0, api::InitRobot{});
      cell->act(0, api::SetGripper{0});
      cell->act(0, to(0.02));
      cell->act(0, api::SetMotionLimit{api::MotionLimit::kTransSpeed, false, 0.02});
    }
    cell->act(0, to(-0.02), 30, {guard({SignalKind::kForceR, 2}, GuardLimit::kIncreased, 2)});
    seen[i++] = cell->now.robots[0].guards;
  }
  EXPECT_EQ(seen[0].trigger_value, seen[1].trigger_value);
  EXPECT_EQ(seen[0].trigger_X_RT.p, seen[1].trigger_X_RT.p);
  EXPECT_EQ(seen[0].stop_time, seen[1].stop_time);
}

TEST_F(OverAGear, AGripperActionMayBeGuardedToo) {
  const double open = cell_.world.description()->robots[0].gripper.gap_open_m;
  const double middle = 0.5 * (robot().gripper.separation_m + open);
  cell_.act(0, api::SetGripper{1}, 30,
            {guard({SignalKind::kSeparation, 0}, GuardLimit::kOverMax, middle)});
  EXPECT_LT(robot().gripper.separation_m, open - 1e-4) << "not at the end yet";
  EXPECT_EQ(robot().guards.triggers, 1U);
}

TEST_F(OverAGear, TheGripForceIsWhatIsSet) {
  cell_.act(0, api::SetGripper{1});
  cell_.act(0, to(-0.012));
  cell_.act(0, api::SetGripperForce{20});
  EXPECT_EQ(robot().gripper.max_force_n, 20);
  cell_.act(0, api::SetGripper{0});
  cell_.advance(200);
  EXPECT_TRUE(robot().gripper.holding);
  EXPECT_NEAR(robot().gripper.force_n[0], 20, 3);
  const double weak = robot().gripper.force_n[0];
  cell_.act(0, api::SetGripperForce{40});
  cell_.advance(300);
  EXPECT_NEAR(robot().gripper.force_n[0], 2 * weak, 4);
  EXPECT_TRUE(robot().gripper.holding);
}

}  // namespace
}  // namespace aprsim::test
