#include "world/robot/controller/guard_monitor.hpp"

#include <chrono>

#include <gtest/gtest.h>

#include "world/api/snapshot/signal_value.hpp"

namespace aprsim::robot {
namespace {

using api::GuardLimit;
using api::SignalKind;
using std::chrono::microseconds;
using std::chrono::milliseconds;

api::Guard guard(GuardLimit limit, double value, SimTime recheck = milliseconds(1)) {
  api::Guard out;
  out.signal = {SignalKind::kForceR, 2};
  out.limit = limit;
  out.value = value;
  out.recheck = recheck;
  out.label = "Fz";
  return out;
}

class Monitor : public testing::Test {
 protected:
  /// One step with that force along z.
  std::optional<std::size_t> step(double fz) {
    robot_.force_T_R.z() = fz;
    const auto triggered = monitor_.check(robot_, now_);
    now_ += milliseconds(1);
    return triggered;
  }

  GuardMonitor monitor_;
  api::RobotSnapshot robot_;
  SimTime now_ = milliseconds(100);
};

TEST_F(Monitor, ReactsAfterItsDelay) {
  const api::Guard only[] = {guard(GuardLimit::kIncreased, 2)};
  monitor_.begin(1, only);
  const auto at = [this](int ms, double fz) {
    robot_.force_T_R.z() = fz;
    return monitor_.check(robot_, milliseconds(ms), milliseconds(30));
  };
  EXPECT_FALSE(at(0, 5));
  EXPECT_FALSE(monitor_.reaction_due());
  EXPECT_FALSE(at(1, 8));
  EXPECT_FALSE(monitor_.active());
  EXPECT_EQ(monitor_.state().triggers, 1U);
  // Neither a later value nor the end of the condition changes the reaction.
  for (int ms = 2; ms < 31; ++ms) EXPECT_FALSE(at(ms, 5)) << ms;
  EXPECT_TRUE(monitor_.reaction_due());
  EXPECT_EQ(at(31, 5), 0U);
  EXPECT_FALSE(monitor_.reaction_due());
  EXPECT_FALSE(at(32, 9));
  // The next command does not inherit it.
  monitor_.begin(2, only);
  EXPECT_FALSE(at(40, 5));
  EXPECT_FALSE(at(41, 8));
  monitor_.begin(3, only);
  EXPECT_FALSE(monitor_.reaction_due());
  for (int ms = 50; ms < 100; ++ms) EXPECT_FALSE(at(ms, 5)) << ms;
}

TEST_F(Monitor, EachLimitTriggersBeyondItsValueOnly) {
  struct Case {
    GuardLimit limit;
    double stays, triggers;
  };
  // All start at 5 with the limit 2.
  for (const Case& one :
       {Case{GuardLimit::kIncreased, 7, 7.01}, {GuardLimit::kDecreased, 3, 2.99}}) {
    const api::Guard only[] = {guard(one.limit, 2)};
    monitor_.begin(1, only);
    EXPECT_FALSE(step(5));
    EXPECT_FALSE(step(one.stays));
    EXPECT_EQ(step(one.triggers), 0U);
    EXPECT_FALSE(monitor_.active());
  }
  for (const Case& one : {Case{GuardLimit::kOverMax, 2, 2.01}, {GuardLimit::kUnderMin, 2, 1.99}}) {
    const api::Guard only[] = {guard(one.limit, 2)};
    monitor_.begin(1, only);
    EXPECT_FALSE(step(one.stays));
    EXPECT_EQ(step(one.triggers), 0U);
  }
  EXPECT_EQ(monitor_.state().triggers, 4U);
}

TEST_F(Monitor, AnAbsoluteLimitMayTriggerAtOnce) {
  const api::Guard only[] = {guard(GuardLimit::kOverMax, 2)};
  monitor_.begin(1, only);
  EXPECT_EQ(step(3), 0U);
}

TEST_F(Monitor, ChecksOnlyWhenDue) {
  const api::Guard only[] = {guard(GuardLimit::kOverMax, 2, milliseconds(10))};
  monitor_.begin(1, only);
  EXPECT_FALSE(step(0));
  for (int i = 0; i < 9; ++i) EXPECT_FALSE(step(3)) << i;
  EXPECT_EQ(monitor_.state().guards[0].checks, 1U);
  EXPECT_EQ(step(3), 0U);
  EXPECT_EQ(monitor_.state().guards[0].checks, 2U);
  EXPECT_EQ(monitor_.state().guards[0].last_check, milliseconds(110));
  EXPECT_EQ(monitor_.state().guards[0].last_value, 3);
}

TEST_F(Monitor, APeriodBelowAStepIsEveryStepAndOthersKeepTheirMean) {
  const api::Guard both[] = {guard(GuardLimit::kOverMax, 2, microseconds(20)),
                             guard(GuardLimit::kOverMax, 2, microseconds(2500))};
  monitor_.begin(1, both);
  for (int i = 0; i < 100; ++i) EXPECT_FALSE(step(0));
  EXPECT_EQ(monitor_.state().guards[0].checks, 100U);
  EXPECT_EQ(monitor_.state().guards[1].checks, 40U);
}

TEST_F(Monitor, KeepsWhereAndHowLong) {
  const api::Guard both[] = {guard(GuardLimit::kUnderMin, -9), guard(GuardLimit::kOverMax, 2)};
  monitor_.begin(7, both);
  robot_.X_RT.p = {1, 2, 3};
  EXPECT_EQ(step(4), 1U);
  EXPECT_TRUE(monitor_.stopping());
  monitor_.at_rest(milliseconds(105));
  monitor_.at_rest(milliseconds(200));
  const api::GuardsSnapshot& state = monitor_.state();
  EXPECT_EQ(state.ticket, 7U);
  EXPECT_EQ(state.count, 2U);
  EXPECT_EQ(state.trigger_guard, 1U);
  EXPECT_EQ(state.trigger_value, 4);
  EXPECT_EQ(state.trigger_X_RT.p, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(state.stop_time, milliseconds(5));
}

TEST_F(Monitor, TellsWhichTriggerIsMissing) {
  api::Guard both[] = {guard(GuardLimit::kOverMax, 2), guard(GuardLimit::kOverMax, 3)};
  both[1].require_trigger = true;
  monitor_.begin(1, both);
  EXPECT_FALSE(step(0));
  ASSERT_NE(monitor_.missing_trigger(), nullptr);
  EXPECT_EQ(monitor_.missing_trigger()->value, 3);
  EXPECT_EQ(step(2.5), 0U);
  EXPECT_EQ(monitor_.missing_trigger(), nullptr);
}

TEST_F(Monitor, ACommandWithoutGuardsEndsTheMonitoringAndKeepsTheLastTrigger) {
  const api::Guard only[] = {guard(GuardLimit::kOverMax, 2)};
  monitor_.begin(1, only);
  EXPECT_EQ(step(3), 0U);
  monitor_.reset();
  EXPECT_FALSE(step(9));
  EXPECT_EQ(monitor_.state().ticket, 1U);
  EXPECT_EQ(monitor_.state().triggers, 1U);
}

TEST(Signals, ReadInTheirFrames) {
  api::RobotSnapshot robot;
  robot.force_T_R = {1, 2, 3};
  robot.torque_T_R = {4, 5, 6};
  robot.X_RT.q = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX());  // tool down
  robot.joints[3].torque_nm = -7;
  robot.gripper.force_n = {8, 9};
  robot.gripper.separation_m = 0.04;
  robot.gripper.holding = true;
  EXPECT_EQ(value_of({SignalKind::kForceR, 2}, robot), 3);
  EXPECT_EQ(value_of({SignalKind::kTorqueR, 0}, robot), 4);
  EXPECT_NEAR(value_of({SignalKind::kForceT, 2}, robot), -3, 1e-12);
  EXPECT_NEAR(value_of({SignalKind::kTorqueT, 1}, robot), -5, 1e-12);
  EXPECT_EQ(value_of({SignalKind::kJointTorque, 3}, robot), -7);
  EXPECT_EQ(value_of({SignalKind::kGripForce, 1}, robot), 9);
  EXPECT_EQ(value_of({SignalKind::kSeparation, 0}, robot), 0.04);
  EXPECT_EQ(value_of({SignalKind::kPartPresent, 0}, robot), 1);
  for (const auto kind : {SignalKind::kForceR, SignalKind::kJointTorque, SignalKind::kGripForce}) {
    EXPECT_EQ(value_of({kind, 99}, robot), 0);
    EXPECT_EQ(value_of({kind, -1}, robot), 0);
  }
}

}  // namespace
}  // namespace aprsim::robot
