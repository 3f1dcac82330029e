#include <chrono>
#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

#include "tests/unit/world/robot/controller/controller_rig.hpp"

namespace aprsim::robot {
namespace {

using api::ActionState;
using api::MotionLimit;
using namespace std::chrono_literals;

class Lifecycle : public testing::Test {
 protected:
  ControllerRig rig{"fanuc"};
};

TEST_F(Lifecycle, NothingActsBeforeInit) {
  EXPECT_EQ(rig.state(), ActionState::kNone);
  EXPECT_FALSE(rig.controller().initialized());
  const Pose here = rig.tool();
  const api::RobotAction actions[] = {api::MoveTo{here, false}, api::MoveJoints{},
                                      api::SetGripper{0}, api::Dwell{1s}};
  for (const auto& action : actions) {
    ControllerRig fresh("fanuc");
    EXPECT_EQ(fresh.run(action), ActionState::kError);
    EXPECT_EQ(fresh.reason().rfind("not initialized", 0), 0u) << fresh.reason();
    EXPECT_EQ(fresh.controller().gripper_setting(), 1.0);
  }
}

TEST_F(Lifecycle, StopAndSettingsWorkBeforeInit) {
  EXPECT_EQ(rig.run(api::StopMotion{}), ActionState::kDone);
  EXPECT_EQ(rig.run(api::SetMotionLimit{MotionLimit::kTransSpeed, false, 0.4}), ActionState::kDone);
  EXPECT_EQ(rig.controller().limit(MotionLimit::kTransSpeed).value, 0.4);
  EXPECT_EQ(rig.run(api::EndProgram{}), ActionState::kDone);
}

TEST_F(Lifecycle, EndStopsMotionAndLeavesTheRobotInitialized) {
  EXPECT_EQ(rig.run(api::InitRobot{}), ActionState::kDone);
  EXPECT_TRUE(rig.controller().initialized());
  EXPECT_EQ(rig.run(api::Dwell{5ms}), ActionState::kDone);
  EXPECT_EQ(rig.run(api::EndProgram{}), ActionState::kDone);
  EXPECT_TRUE(rig.controller().initialized());
  EXPECT_EQ(rig.run(api::Dwell{5ms}), ActionState::kDone);
}

TEST_F(Lifecycle, ErrorsAreHeldUntilInit) {
  rig.run(api::InitRobot{});
  ASSERT_EQ(rig.run(api::MoveJoints{{{0, 9, {}, {}}}}), ActionState::kError);
  const std::string held = rig.reason();
  EXPECT_FALSE(rig.controller().initialized());
  rig.steps(20);
  EXPECT_EQ(rig.state(), ActionState::kError);
  for (const api::RobotAction& action :
       {api::RobotAction{api::Dwell{1s}}, api::RobotAction{api::SetGripper{0}},
        api::RobotAction{api::EndProgram{}}, api::RobotAction{api::MoveTo{rig.tool(), true}}}) {
    EXPECT_EQ(rig.run(action), ActionState::kError);
    EXPECT_EQ(rig.reason(), held);
    EXPECT_EQ(rig.controller().status().ticket, rig.ticket());
  }
  EXPECT_EQ(rig.run(api::InitRobot{}), ActionState::kDone);
  EXPECT_EQ(rig.reason(), "");
}

TEST_F(Lifecycle, DwellTakesItsTime) {
  rig.run(api::InitRobot{});
  for (const auto& [duration, steps] :
       {std::pair<SimTime, int>{0ns, 1}, {1ms, 1}, {250ms, 250}, {1500us, 2}}) {
    rig.apply(api::Dwell{duration});
    for (int i = 1; i < steps; ++i) {
      rig.step();
      ASSERT_EQ(rig.state(), ActionState::kWorking) << i;
    }
    rig.step();
    EXPECT_EQ(rig.state(), ActionState::kDone) << steps;
  }
}

TEST_F(Lifecycle, GripperIsDoneWhenItHasSettled) {
  rig.run(api::InitRobot{});
  EXPECT_EQ(rig.controller().gripper_setting(), 1.0);
  rig.apply(api::SetGripper{0});
  EXPECT_EQ(rig.controller().gripper_setting(), 0.0);
  rig.step(true);  // settled under the setting before
  EXPECT_EQ(rig.state(), ActionState::kWorking);
  for (int i = 0; i < 150; ++i) {
    rig.step(false);
    ASSERT_EQ(rig.state(), ActionState::kWorking);
  }
  rig.step(true);
  EXPECT_EQ(rig.state(), ActionState::kDone);
}

TEST_F(Lifecycle, GripperThatNeverSettlesIsGivenUpAfterTwoSeconds) {
  rig.run(api::InitRobot{});
  rig.apply(api::SetGripper{1});
  int steps = 0;
  while (rig.state() == ActionState::kWorking && steps < 5000) {
    rig.step(false);
    ++steps;
  }
  EXPECT_EQ(rig.state(), ActionState::kDone);
  EXPECT_EQ(steps, 2000);
}

/// A move with a gripper and a dwell beside it is the same bit for bit as without.
TEST_F(Lifecycle, GripperAndDwellAreDoneBesideAMotionThatGoesOn) {
  rig.ready();
  const JointVector start = rig.controller().reference();
  Pose goal = rig.tool();
  goal.p.z() -= 0.1;
  for (const bool straight : {true, false}) {
    rig.run(move_all(start));
    rig.forget();
    rig.run(api::MoveTo{goal, straight});
    const std::vector<JointVector> alone = rig.path();
    rig.run(move_all(start));
    rig.forget();
    rig.apply(api::MoveTo{goal, straight});
    rig.steps(50);
    rig.apply(api::SetGripper{0});
    EXPECT_EQ(rig.controller().gripper_setting(), 0.0);
    EXPECT_EQ(rig.state(), ActionState::kWorking);
    rig.step(false);
    rig.step(true);
    EXPECT_EQ(rig.state(), ActionState::kDone);
    EXPECT_TRUE(rig.controller().moving());
    rig.apply(api::Dwell{100ms});
    rig.steps(99);
    EXPECT_EQ(rig.state(), ActionState::kWorking);
    rig.step();
    EXPECT_EQ(rig.state(), ActionState::kDone);
    EXPECT_TRUE(rig.controller().moving());
    EXPECT_TRUE(rig.controller().X_RG());
    rig.apply(api::SetGripper{1});
    rig.rest();
    EXPECT_EQ(rig.path(), alone) << straight;
    EXPECT_EQ(rig.state(), ActionState::kDone);
  }
  // A command that needs the arm itself still ends the motion.
  rig.run(move_all(start));
  rig.apply(api::MoveTo{goal, true});
  rig.steps(150);
  rig.apply(api::Dwell{10s});
  rig.steps(50);
  EXPECT_EQ(rig.run(api::StopMotion{}), ActionState::kDone);
  EXPECT_FALSE(rig.controller().moving());
  EXPECT_GT((rig.tool().p - goal.p).norm(), 0.01);
}

TEST_F(Lifecycle, LimitsAreClamped) {
  const auto set = [&](MotionLimit which, bool relative, double value) {
    rig.run(api::InitRobot{});
    return rig.run(api::SetMotionLimit{which, relative, value});
  };
  EXPECT_EQ(set(MotionLimit::kTransSpeed, false, 99), ActionState::kDone);
  EXPECT_EQ(rig.controller().limit(MotionLimit::kTransSpeed).value, 1.5);
  EXPECT_EQ(set(MotionLimit::kRotAccel, true, 0.5), ActionState::kDone);
  EXPECT_TRUE(rig.controller().limit(MotionLimit::kRotAccel).relative);
  EXPECT_EQ(rig.controller().limit(MotionLimit::kRotAccel).value, 0.5);
}

TEST_F(Lifecycle, RestKeepsEveryBit) {
  rig.run(api::InitRobot{});
  rig.run(move_all(JointVector::Constant(6, 0.1234567)));
  const JointVector here = rig.controller().reference();
  for (int i = 0; i < 20000; ++i) {
    ASSERT_EQ(rig.controller().step({.gripper_settled = i % 2 == 0}), here);
  }
}

TEST_F(Lifecycle, MotionStartsInTheStepAfterTheCommand) {
  rig.run(api::InitRobot{});
  const JointVector here = rig.controller().reference();
  rig.apply(move_all(here + JointVector::Constant(6, 0.1)));
  EXPECT_EQ(rig.controller().reference(), here);
  EXPECT_TRUE(rig.controller().moving());
  rig.step();
  EXPECT_NE(rig.controller().reference(), here);
}

TEST(ControllerSetupCheck, RefusesWhatMakesNoRobot) {
  auto setup = rig_setup("fanuc");
  setup.max_trans_speed_m_s = 0;
  EXPECT_THROW(RobotController{setup}, std::invalid_argument);
  setup = rig_setup("fanuc");
  setup.q_home(2) = 9;
  EXPECT_THROW(RobotController{setup}, std::invalid_argument);
  setup = rig_setup("fanuc");
  setup.ik.reset();
  EXPECT_THROW(RobotController{setup}, std::invalid_argument);
}

}  // namespace
}  // namespace aprsim::robot
