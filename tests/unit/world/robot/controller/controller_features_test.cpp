#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/allocation_counter.hpp"
#include "tests/unit/world/robot/controller/controller_rig.hpp"
#include "world/robot/controller/controller_state.hpp"

namespace aprsim::robot {
namespace {

using api::ActionState;
using Eigen::Vector3d;

/// Speed override, blending, torque, tool changer, checkpoints.
class Features : public testing::TestWithParam<const char*> {
 protected:
  Features() : rig(GetParam()) {
    rig.run(api::InitRobot{});
    posture = JointVector(rig.dof());
    if (rig.dof() == 6) {
      posture << 0.2, 0.4, -0.4, 0.1, -0.9, 0.3;
    } else {
      posture << 0.2, 0.5, 0.3, -1.4, 0.2, -1.0, 0.3;
    }
    rig.run(move_all(posture));
    rig.forget();
  }
  Pose shifted(const Vector3d& by) const {
    Pose X = Pose::from(rig.X_RT(posture));
    X.p += by;
    return X;
  }
  double speed() const {
    const auto& path = rig.path();
    const JointVector& a = path[path.size() - 2];
    return (rig.X_RT(path.back()).translation() - rig.X_RT(a).translation()).norm() * 1e3;
  }
  /// Every kind of motion there is.
  std::vector<api::RobotAction> motions() const {
    return {
        api::MoveTo{shifted({0.12, 0.02, -0.05}), true},
        api::MoveTo{shifted({0.12, 0.02, -0.05}), false},
        api::MoveThroughTo{
            {api::Waypoint{shifted({0.08, 0, 0})}, api::Waypoint{shifted({0.08, 0.08, 0})}}, true},
        api::MoveThroughTo{
            {api::Waypoint{shifted({0.08, 0, 0})}, api::Waypoint{shifted({0.08, 0.08, 0})}}, false},
        api::MoveScrew{.screw_m = 0.03, .turn_rad = 1.5},
        api::MoveJoints{{{0, posture(0) + 0.4, 0.3, {}}, {1, posture(1) - 0.2, {}, {}}}}};
  }
  ControllerRig rig;
  JointVector posture;
};
INSTANTIATE_TEST_SUITE_P(Arms, Features, testing::Values("fanuc", "motoman"),
                         [](const auto& arm) { return std::string(arm.param); });

TEST_P(Features, OverrideScalesRunningMotionSmoothlyAndEndsExactly) {
  for (const api::RobotAction& action : motions()) {
    SCOPED_TRACE(action.index());
    rig.run(move_all(posture));
    rig.run(api::SetOverride{1});
    rig.run(action);
    const JointVector end = rig.controller().reference();
    rig.run(move_all(posture));
    rig.forget();
    rig.apply(action);
    rig.steps(300);
    rig.apply(api::SetOverride{0.2});
    EXPECT_EQ(rig.state(), ActionState::kDone);  // a setting, done at once
    EXPECT_TRUE(rig.controller().moving());
    rig.steps(400);
    rig.apply(api::SetOverride{0.7});
    rig.steps(300);
    rig.apply(api::SetOverride{0.1});
    rig.steps(10);
    rig.apply(api::SetOverride{1});
    rig.rest();
    EXPECT_LE((rig.controller().reference() - end).cwiseAbs().maxCoeff(), 1e-12);
    const auto effort = rig.effort();
    EXPECT_LE(effort.speed, 1.001);
    EXPECT_LE(effort.accel, 1.1);
    EXPECT_LE(effort.jerk, 2.0);
  }
}

TEST_P(Features, OverrideSlowsLaterMotionInProportion) {
  rig.run(api::SetOverride{0.4});
  EXPECT_EQ(rig.controller().override_fraction(), 0.4);
  rig.forget();
  ASSERT_EQ(rig.run(api::MoveTo{shifted({0, 0, -0.1}), true}), ActionState::kDone);
  EXPECT_NEAR(rig.effort().tool_speed, 0.1, 1e-4);
}

TEST_P(Features, OverrideZeroHoldsTheMotionAndAStopStillStops) {
  for (const api::RobotAction& action : motions()) {
    SCOPED_TRACE(action.index());
    rig.run(move_all(posture));
    rig.apply(action);
    rig.steps(250);
    rig.apply(api::SetOverride{0});
    rig.steps(2500);
    const JointVector held = rig.controller().reference();
    rig.steps(500);
    EXPECT_EQ(rig.controller().reference(), held);
    EXPECT_TRUE(rig.controller().moving());
    rig.apply(api::StopMotion{});
    rig.steps(2);
    EXPECT_EQ(rig.state(), ActionState::kDone);
    EXPECT_EQ(rig.controller().reference(), held);
    // A move that is given now waits as well.
    rig.apply(api::MoveTo{shifted({0, 0, 0}), true});
    rig.steps(50);
    EXPECT_EQ(rig.controller().reference(), held);
    EXPECT_EQ(rig.state(), ActionState::kWorking);
    rig.apply(api::SetOverride{1});
    rig.rest();
    EXPECT_LE((rig.tool().p - shifted({0, 0, 0}).p).norm(), 1e-9);
  }
}

/// Two free moves the same way: the second one blends without a stop, in the step after the
/// command.
TEST_P(Features, AFreeMoveBlendsWithoutStopping) {
  rig.apply(api::MoveTo{shifted({0.06, 0, 0}), false});
  rig.steps(350);
  const double before = speed();
  ASSERT_GT(before, 0.05);
  rig.apply(api::MoveTo{shifted({0.15, 0.02, 0}), false});
  double slowest = 1e9;
  for (int i = 0; i < 200; ++i) {
    rig.step();
    slowest = std::min(slowest, speed());
  }
  EXPECT_GT(slowest, 0.4 * before);
  rig.rest();
  EXPECT_EQ(rig.state(), ActionState::kDone);
  EXPECT_LE((rig.tool().p - shifted({0.15, 0.02, 0}).p).norm(), 1e-9);
  const auto effort = rig.effort();
  EXPECT_LE(effort.speed, 1.001);
  EXPECT_LE(effort.accel, 1.05);
  EXPECT_LE(effort.jerk, 1.2);
  EXPECT_LE(effort.tool_speed, 0.25 * 1.1);
}

TEST_P(Features, AReversedMovePassesOverSmoothly) {
  const JointVector start = posture;
  rig.apply(api::MoveJoints{{{0, start(0) + 0.6, {}, {}}}});
  rig.steps(500);
  rig.apply(api::MoveJoints{{{0, start(0) - 0.2, {}, {}}}});
  rig.rest();
  EXPECT_EQ(rig.controller().reference()(0), start(0) - 0.2);
  const auto effort = rig.effort();
  EXPECT_LE(effort.accel, 1.05);
  EXPECT_LE(effort.jerk, 1.2);
}

/// A saved controller, put back into another one in the middle of any motion, goes on with the same
/// bits.
TEST_P(Features, ACopyOfTheStateContinuesBitForBit) {
  for (const api::RobotAction& action : motions()) {
    for (const int steps : {0, 1, 150, 420}) {
      SCOPED_TRACE(testing::Message() << action.index() << " after " << steps);
      rig.run(move_all(posture));
      rig.apply(action);
      rig.steps(steps);
      const ControllerState saved = rig.controller().save();
      std::vector<JointVector> expected;
      const auto go_on = [&](RobotController& controller) {
        std::vector<JointVector> path;
        for (int i = 0; i < 200; ++i) path.push_back(controller.step());
        controller.apply(99, api::StopMotion{api::StopKind::kFast}, controller.reference());
        for (int i = 0; i < 400; ++i) path.push_back(controller.step());
        controller.apply(100, api::MoveTo{shifted({0, 0.05, 0}), false}, controller.reference());
        for (int i = 0; i < 200; ++i) path.push_back(controller.step());
        return path;
      };
      const auto first = go_on(rig.controller());
      RobotController other(rig.setup());
      other.restore(saved);
      EXPECT_EQ(go_on(other), first);
      rig.controller().restore(saved);
      EXPECT_EQ(go_on(rig.controller()), first);
      EXPECT_EQ(rig.controller().status().ticket, 100u);
    }
  }
}

TEST_P(Features, ARestoredControllerStepsWithoutAllocation) {
  rig.apply(motions()[2]);
  rig.steps(100);
  const ControllerState saved = rig.controller().save();
  rig.steps(50);
  rig.controller().restore(saved);
  const auto before = aprsim::test::allocations();
  for (int i = 0; i < 300; ++i) rig.controller().step();
  EXPECT_EQ(aprsim::test::allocations(), before);
}

/// A spring of 2000 Nm/rad stands in the way of joint 1.
TEST_P(Features, ATorqueDrivenJointComesToBalance) {
  const double wall = posture(0) + 0.1;
  const double setting = 20;
  rig.apply(api::MoveJoints{{{.joint = 0,
                              .position_rad = posture(0) + 0.25,
                              .speed_rad_s = {},
                              .accel_rad_s2 = {},
                              .torque = api::JointTorque{setting, 100}},
                             {1, posture(1) - 0.05, {}, {}}}});
  JointVector external = JointVector::Zero(rig.dof());
  double most = 0;
  for (int i = 0; i < 20000 && rig.state() == ActionState::kWorking; ++i) {
    rig.load(external);
    external(0) = -2000 * std::max(0.0, rig.controller().reference()(0) - wall);
    most = std::max(most, -external(0));
  }
  EXPECT_EQ(rig.state(), ActionState::kDone);
  EXPECT_NEAR(-external(0), setting, 0.06 * setting);
  EXPECT_LE(most, 1.1 * setting);
  EXPECT_NE(rig.reason().find("is held at"), std::string::npos) << rig.reason();
  EXPECT_EQ(rig.controller().reference()(1), posture(1) - 0.05);
  // It yields to more than its torque, and advances again when that goes.
  for (int i = 0; i < 4000; ++i) {
    external(0) = -30;
    rig.load(external);
  }
  EXPECT_LT(rig.controller().reference()(0), wall);
  external.setZero();
  for (int i = 0; i < 60000; ++i) rig.load(external);
  EXPECT_EQ(rig.controller().reference()(0), posture(0) + 0.25);
}

TEST_P(Features, ATorqueDrivenJointReachesItsPositionWhereNothingStands) {
  ASSERT_EQ(rig.run(api::MoveJoints{{{.joint = 0,
                                      .position_rad = posture(0) - 0.1,
                                      .speed_rad_s = {},
                                      .accel_rad_s2 = {},
                                      .torque = api::JointTorque{10, {}}}}}),
            ActionState::kDone);
  EXPECT_EQ(rig.controller().reference()(0), posture(0) - 0.1);
  EXPECT_EQ(rig.reason(), "");
  EXPECT_LE(rig.effort().accel, 1.05);
}

TEST_P(Features, AStopEndsATorqueDrive) {
  rig.apply(api::MoveJoints{{{.joint = 0,
                              .position_rad = posture(0) + 1,
                              .speed_rad_s = {},
                              .accel_rad_s2 = {},
                              .torque = api::JointTorque{10, {}}}}});
  rig.steps(300);
  rig.apply(api::StopMotion{});
  rig.rest();
  EXPECT_EQ(rig.state(), ActionState::kDone);
  const JointVector stopped = rig.controller().reference();
  rig.steps(100);
  EXPECT_EQ(rig.controller().reference(), stopped);
}

TEST_P(Features, TorqueBeyondTheDrivesIsRefused) {
  EXPECT_EQ(rig.run(api::MoveJoints{{{.joint = 0,
                                      .position_rad = posture(0) + 1,
                                      .speed_rad_s = {},
                                      .accel_rad_s2 = {},
                                      .torque = api::JointTorque{1e5, {}}}}}),
            ActionState::kError);
  EXPECT_NE(rig.reason().find("torque 100000 Nm is greater than its limit"), std::string::npos)
      << rig.reason();
}

TEST_P(Features, TheToolChangerChangesTheControlledPoint) {
  const Pose with_tool = rig.tool();
  ASSERT_EQ(rig.run(api::SetToolChanger{true}), ActionState::kDone);
  EXPECT_EQ(rig.controller().tool(), -1);
  EXPECT_TRUE(rig.controller().X_FT().isApprox(Eigen::Isometry3d::Identity()));
  // The flange now goes where the tool was told to go.
  Pose target = with_tool;
  target.p.z() += 0.1;
  ASSERT_EQ(rig.run(api::MoveTo{target, false}), ActionState::kDone) << rig.reason();
  const Eigen::Isometry3d X_RF =
      rig.setup().X_BR.inverse() * flange_pose(rig.model(), rig.controller().reference());
  EXPECT_LE((X_RF.translation() - target.p).norm(), 1e-9);
  EXPECT_EQ(rig.run(api::SetGripper{0}), ActionState::kError);
  EXPECT_EQ(rig.reason().rfind("no tool is on the robot", 0), 0u) << rig.reason();
  rig.run(api::InitRobot{});
  rig.apply(api::SetToolChanger{false});
  rig.controller().step({.tool_at_flange = -1});
  EXPECT_EQ(rig.state(), ActionState::kDone);
  EXPECT_EQ(rig.reason(), "nothing taken: no tool is at the flange");
  EXPECT_EQ(rig.controller().tool(), -1);
  EXPECT_EQ(rig.run(api::SetToolChanger{false}), ActionState::kDone);
  EXPECT_EQ(rig.controller().tool(), 0);
  EXPECT_EQ(rig.run(api::SetGripper{0}), ActionState::kDone);
}

}  // namespace
}  // namespace aprsim::robot
