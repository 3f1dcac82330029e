#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/unit/world/robot/controller/controller_rig.hpp"

namespace aprsim::robot {
namespace {

using api::ActionState;
using api::StopKind;

class Replacement : public testing::TestWithParam<const char*> {
 protected:
  Replacement() : rig(GetParam()) { rig.ready(); }
  Eigen::Isometry3d shifted(const Eigen::Vector3d& by) const {
    Eigen::Isometry3d X = rig.X_RT(rig.path().back());
    X.translation() += by;
    return X;
  }
  /// No step faster or harder than the joints may, with a margin for sampled accelerations.
  void expect_smooth(double accel = 1.05) const {
    const auto effort = rig.effort();
    EXPECT_LE(effort.speed, 1 + 1e-3);
    EXPECT_LE(effort.accel, accel);
  }
  ControllerRig rig;
};
INSTANTIATE_TEST_SUITE_P(Arms, Replacement, testing::Values("fanuc", "motoman"),
                         [](const auto& arm) { return std::string(arm.param); });

TEST_P(Replacement, NewestMoveWinsAndTheOldOneIsNeverDone) {
  for (const bool first_straight : {false, true}) {
    for (const bool second_straight : {false, true}) {
      const Pose a = Pose::from(shifted({0.1, 0, -0.05}));
      const Pose b = Pose::from(shifted({0, 0.08, 0.03}));
      rig.apply(api::MoveTo{a, first_straight});
      const api::Ticket old = rig.ticket();
      for (int i = 0; i < 250; ++i) {
        rig.step();
        ASSERT_EQ(rig.state(), ActionState::kWorking);
        ASSERT_EQ(rig.controller().status().ticket, old);
      }
      ASSERT_EQ(rig.run(api::MoveTo{b, second_straight}), ActionState::kDone) << rig.reason();
      EXPECT_EQ(rig.controller().status().ticket, old + 1);
      EXPECT_LE((rig.tool().p - b.p).norm(), 1e-9);
      expect_smooth();
    }
  }
}

TEST_P(Replacement, ManyReplacementsAtRandomTimesStaySmooth) {
  std::mt19937 engine(8);
  std::uniform_real_distribution<double> shift(-0.1, 0.1);
  std::uniform_int_distribution<int> pause(0, 400);
  const Eigen::Isometry3d centre = shifted({0, 0, 0});
  Eigen::Isometry3d X = centre;
  for (int n = 0; n < 40; ++n) {
    X = centre;
    X.translation() += Eigen::Vector3d(shift(engine), shift(engine), shift(engine));
    rig.apply(api::MoveTo{Pose::from(X), n % 3 != 0});
    ASSERT_NE(rig.state(), ActionState::kError) << rig.reason();
    rig.steps(pause(engine));
  }
  rig.rest();
  EXPECT_EQ(rig.state(), ActionState::kDone);
  EXPECT_LE((rig.tool().p - X.translation()).norm(), 1e-9);
  expect_smooth();
}

TEST_P(Replacement, StopsOfEveryKind) {
  for (const bool straight : {false, true}) {
    double way[3] = {};
    for (const StopKind kind : {StopKind::kImmediate, StopKind::kFast, StopKind::kNormal}) {
      const Eigen::Isometry3d from = shifted({0, 0, 0});
      const Eigen::Isometry3d to = shifted({0.12, 0.05, -0.08});
      rig.apply(api::MoveTo{Pose::from(to), straight});
      const api::Ticket interrupted = rig.ticket();
      rig.steps(350);
      const Eigen::Vector3d before = rig.tool().p;
      rig.apply(api::StopMotion{kind});
      EXPECT_EQ(rig.state(), ActionState::kWorking);
      EXPECT_EQ(rig.controller().status().ticket, interrupted + 1);
      EXPECT_TRUE(rig.controller().moving());
      rig.rest();
      EXPECT_EQ(rig.state(), ActionState::kDone);
      const Eigen::Vector3d after = rig.tool().p;
      way[static_cast<int>(kind)] = (after - before).norm();
      EXPECT_GT((after - to.translation()).norm(), 0.02);
      if (straight && kind != StopKind::kImmediate) {
        const Eigen::Vector3d d = after - from.translation();
        const Eigen::Vector3d line = (to.translation() - from.translation()).normalized();
        EXPECT_LE((d - d.dot(line) * line).norm(), 1e-9);
      }
      const JointVector stopped = rig.controller().reference();
      rig.steps(100);
      EXPECT_EQ(rig.controller().reference(), stopped);
      expect_smooth();
      ASSERT_EQ(rig.run(api::MoveTo{Pose::from(from), true}), ActionState::kDone) << rig.reason();
      rig.forget();
    }
    EXPECT_LT(way[0], way[2]);
    EXPECT_LE(way[1], way[2] + 1e-9);
  }
}

/// They differ in distance, time and path: immediate leaves the line, the other two stay on it.
TEST_P(Replacement, TheThreeStopsDiffer) {
  rig.run(api::SetMotionLimit{api::MotionLimit::kTransAccel, false, 0.6});
  const Eigen::Isometry3d from = shifted({0, 0, 0});
  const Eigen::Isometry3d to = shifted({0.12, 0.08, -0.1});
  const Eigen::Vector3d line = (to.translation() - from.translation()).normalized();
  double way[3] = {}, off[3] = {};
  int steps[3] = {};
  for (const StopKind kind : {StopKind::kImmediate, StopKind::kFast, StopKind::kNormal}) {
    const auto i = static_cast<std::size_t>(kind);
    ASSERT_EQ(rig.run(api::MoveTo{Pose::from(from), true}), ActionState::kDone);
    rig.apply(api::MoveTo{Pose::from(to), true});
    rig.steps(450);
    const Eigen::Vector3d before = rig.tool().p;
    rig.apply(api::StopMotion{kind});
    for (; rig.controller().moving(); ++steps[i]) {
      rig.step();
      const Eigen::Vector3d d = rig.tool().p - from.translation();
      off[i] = std::max(off[i], (d - d.dot(line) * line).norm());
    }
    way[i] = (rig.tool().p - before).norm();
  }
  EXPECT_LT(way[0], 0.8 * way[1]);
  EXPECT_LT(way[1], 0.8 * way[2]);
  EXPECT_LT(steps[0], steps[1]);
  EXPECT_LT(steps[1], steps[2]);
  EXPECT_GT(off[0], 1e-6);
  EXPECT_LT(off[1], 1e-9);
  EXPECT_LT(off[2], 1e-9);
}

TEST_P(Replacement, StopAtRestIsDoneInTheNextStep) {
  const JointVector here = rig.controller().reference();
  rig.apply(api::StopMotion{});
  rig.step();
  EXPECT_EQ(rig.state(), ActionState::kDone);
  EXPECT_EQ(rig.controller().reference(), here);
}

TEST_P(Replacement, UnnamedJointsKeepTheirTargets) {
  const JointVector start = rig.controller().reference();
  rig.apply(api::MoveJoints{{{0, start(0) + 0.5, {}, {}}}});
  rig.steps(200);
  ASSERT_EQ(rig.run(api::MoveJoints{{{1, start(1) - 0.2, {}, {}}}}), ActionState::kDone);
  EXPECT_EQ(rig.controller().reference()(0), start(0) + 0.5);
  EXPECT_EQ(rig.controller().reference()(1), start(1) - 0.2);
  expect_smooth();
}

TEST_P(Replacement, AStopEndsTheTargetsOfJoints) {
  const JointVector start = rig.controller().reference();
  rig.apply(api::MoveJoints{{{0, start(0) + 0.5, {}, {}}}});
  rig.steps(200);
  rig.run(api::StopMotion{});
  const double stopped = rig.controller().reference()(0);
  ASSERT_EQ(rig.run(api::MoveJoints{{{1, start(1) - 0.2, {}, {}}}}), ActionState::kDone);
  EXPECT_EQ(rig.controller().reference()(0), stopped);
}

TEST_P(Replacement, ARefusedMoveStopsTheRunningOne) {
  rig.apply(api::MoveTo{Pose::from(shifted({0.1, 0, 0})), true});
  rig.steps(300);
  Pose far = rig.tool();
  far.p.x() += 5;
  rig.apply(api::MoveTo{far, true});
  EXPECT_EQ(rig.state(), ActionState::kError);
  rig.rest();
  EXPECT_EQ(rig.state(), ActionState::kError);
  EXPECT_GT((rig.tool().p - far.p).norm(), 4.0);
  expect_smooth();
}

TEST_P(Replacement, TheGoalIsThatOfTheRunningMove) {
  std::mt19937 engine(3);
  const JointVector q = rig.random_posture(engine, 0.2);
  EXPECT_FALSE(rig.controller().X_RG());
  rig.apply(move_all(q));
  rig.steps(20);
  ASSERT_TRUE(rig.controller().X_RG());
  EXPECT_LT((rig.controller().X_RG()->p - rig.X_RT(q).translation()).norm(), 1e-9);
  EXPECT_EQ(rig.controller().status().kind, api::ActionKind::kMoveJoints);
  rig.apply(api::SetOverride{0.5});
  EXPECT_TRUE(rig.controller().X_RG()) << "a setting leaves the move alone";
  EXPECT_EQ(rig.controller().status().kind, api::ActionKind::kOverride);
  Pose aside = rig.tool();
  aside.p.z() += 0.01;
  rig.apply(api::MoveTo{aside, false});
  ASSERT_TRUE(rig.controller().X_RG());
  EXPECT_LT((rig.controller().X_RG()->p - aside.p).norm(), 1e-9);
  rig.apply(api::StopMotion{});
  EXPECT_FALSE(rig.controller().X_RG());
}

TEST_P(Replacement, InitRobotAbortsMotion) {
  rig.apply(api::MoveTo{Pose::from(shifted({0.1, 0, 0})), true});
  rig.steps(300);
  const JointVector before = rig.controller().reference();
  ASSERT_EQ(rig.run(api::InitRobot{}), ActionState::kDone);
  EXPECT_FALSE(rig.controller().moving());
  EXPECT_LT((rig.controller().reference() - before).norm(), 0.05);
  expect_smooth();
}

TEST_P(Replacement, ASettingLeavesTheRunningMoveAlone) {
  const Eigen::Isometry3d X = shifted({0.1, 0, 0});
  rig.apply(api::MoveTo{Pose::from(X), true});
  rig.steps(100);
  rig.apply(api::SetMotionLimit{api::MotionLimit::kTransSpeed, true, 0.1});
  EXPECT_EQ(rig.state(), ActionState::kDone);
  EXPECT_TRUE(rig.controller().moving());
  rig.rest();
  EXPECT_LE((rig.tool().p - X.translation()).norm(), 1e-9);
  EXPECT_EQ(rig.state(), ActionState::kDone);
}

TEST_P(Replacement, ProtectiveStopHoldsUntilInit) {
  const Eigen::Isometry3d X = shifted({0.1, 0, 0});
  rig.apply(api::MoveTo{Pose::from(X), true});
  rig.steps(300);
  JointVector actual = rig.controller().reference();
  actual(1) += 1e-3;
  rig.controller().protective_stop("joint_2: torque 90 Nm is over its limit 78 Nm", actual);
  EXPECT_EQ(rig.state(), ActionState::kError);
  EXPECT_TRUE(rig.controller().stopped_by_protection());
  EXPECT_FALSE(rig.controller().initialized());
  EXPECT_EQ(rig.controller().reference(), actual);
  // Back by a few millimetres on the way it came.
  const Eigen::Vector3d stopped = rig.tool().p;
  rig.rest();
  const Eigen::Vector3d back = rig.tool().p - stopped;
  EXPECT_LT(back.x(), -4e-3);
  EXPECT_LT(back.norm(), 12e-3);
  EXPECT_EQ(rig.state(), ActionState::kError);
  const std::string held = rig.reason();
  EXPECT_EQ(rig.run(api::MoveTo{Pose::from(X), true}), ActionState::kError);
  EXPECT_EQ(rig.reason(), held);
  EXPECT_EQ(rig.run(api::StopMotion{}), ActionState::kError);
  EXPECT_EQ(rig.run(api::SetMotionLimit{api::MotionLimit::kRotSpeed, true, 0.5}),
            ActionState::kError);
  EXPECT_EQ(rig.reason(), held);
  EXPECT_EQ(rig.controller().limit(api::MotionLimit::kRotSpeed).value, 0.5);
  EXPECT_EQ(rig.run(api::InitRobot{}), ActionState::kDone);
  EXPECT_FALSE(rig.controller().stopped_by_protection());
  EXPECT_EQ(rig.reason(), "");
  EXPECT_EQ(rig.run(api::MoveTo{Pose::from(X), true}), ActionState::kDone) << rig.reason();
}

}  // namespace
}  // namespace aprsim::robot
