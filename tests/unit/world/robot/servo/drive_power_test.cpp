// Stops that leave the arm to its brakes, and what switches the drives on again.

#include <cmath>

#include <gtest/gtest.h>

#include "tests/unit/world/robot/controller/controller_rig.hpp"

namespace aprsim::robot {
namespace {

using api::ActionState;
using api::StopKind;

constexpr int kSecond = 1000, kRelease = 100;  // steps

class DrivesAfterStops : public testing::Test {
 protected:
  void SetUp() override { rig.ready(); }

  /// Stops a motion that is well under way.
  void stop(StopKind kind) {
    rig.apply(there());
    rig.steps(300);
    ASSERT_TRUE(rig.controller().moving());
    rig.apply(api::StopMotion{kind});
  }
  api::MoveJoints there() const {
    return {{{.joint = 0, .position_rad = rig_setup("fanuc").q_home(0) + 0.7}}};
  }
  bool on() { return rig.controller().drives_on(); }

  ControllerRig rig{"fanuc"};
};

TEST_F(DrivesAfterStops, ANormalStopLeavesThemOn) {
  stop(StopKind::kNormal);
  rig.rest();
  rig.steps(3 * kSecond);
  EXPECT_TRUE(on());
  EXPECT_FALSE(rig.controller().braked());
}

TEST_F(DrivesAfterStops, AnImmediateOneSwitchesThemOffAtRest) {
  stop(StopKind::kImmediate);
  EXPECT_TRUE(on());
  while (rig.controller().moving()) {
    rig.step();
    ASSERT_TRUE(on() || !rig.controller().moving());
  }
  rig.step();
  EXPECT_FALSE(on());
  EXPECT_EQ(rig.state(), ActionState::kDone);
}

TEST_F(DrivesAfterStops, AFastOneASecondLater) {
  stop(StopKind::kFast);
  rig.steps(kSecond - 1);
  EXPECT_FALSE(rig.controller().moving());
  EXPECT_EQ(rig.state(), ActionState::kDone) << "at rest, not when the drives go off";
  EXPECT_TRUE(on());
  rig.step();
  EXPECT_FALSE(on());
  EXPECT_TRUE(rig.controller().braked());
}

TEST_F(DrivesAfterStops, StayOnForACommandWithinTheSecond) {
  for (const api::RobotAction& action :
       {api::RobotAction(there()), api::RobotAction(api::InitRobot{}),
        api::RobotAction(api::StopMotion{StopKind::kNormal})}) {
    stop(StopKind::kFast);
    rig.steps(kSecond / 2);
    ASSERT_EQ(rig.run(action), ActionState::kDone) << rig.reason();
    rig.steps(2 * kSecond);
    EXPECT_TRUE(on()) << action.index();
    rig.ready();
  }
}

TEST_F(DrivesAfterStops, AMotionWaitsForTheBrakesToRelease) {
  stop(StopKind::kFast);
  rig.steps(kSecond);
  ASSERT_FALSE(on());
  const JointVector here = rig.controller().reference();
  rig.apply(there());
  EXPECT_TRUE(on());
  EXPECT_TRUE(rig.controller().moving());
  rig.steps(kRelease - 1);
  EXPECT_TRUE(rig.controller().braked());
  EXPECT_EQ(rig.controller().reference(), here);
  rig.steps(20);
  EXPECT_FALSE(rig.controller().braked());
  EXPECT_NE(rig.controller().reference(), here);
  rig.rest();
  EXPECT_EQ(rig.state(), ActionState::kDone) << rig.reason();
  EXPECT_EQ(rig.controller().reference()(0), there().targets[0].position_rad);
}

TEST_F(DrivesAfterStops, InitRobotIsDoneOnceTheBrakesHaveReleased) {
  stop(StopKind::kImmediate);
  rig.rest();
  rig.step();
  ASSERT_FALSE(on());
  rig.apply(api::InitRobot{});
  rig.steps(kRelease - 1);
  EXPECT_EQ(rig.state(), ActionState::kWorking);
  rig.step();
  EXPECT_EQ(rig.state(), ActionState::kDone);
  EXPECT_FALSE(rig.controller().braked());
}

TEST_F(DrivesAfterStops, StayOffForACommandThatNeedsNone) {
  stop(StopKind::kImmediate);
  rig.rest();
  rig.step();
  for (const api::RobotAction& action :
       {api::RobotAction(api::SetGripper{0}), api::RobotAction(api::Dwell{SimTime(1'000'000)}),
        api::RobotAction(api::StopMotion{StopKind::kFast}), api::RobotAction(api::StopMotion{})}) {
    EXPECT_EQ(rig.run(action), ActionState::kDone) << rig.reason();
    EXPECT_FALSE(on()) << action.index();
  }
}

}  // namespace
}  // namespace aprsim::robot
