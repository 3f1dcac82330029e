#include <cmath>
#include <random>

#include <Eigen/SVD>
#include <gtest/gtest.h>

#include "tests/unit/world/robot/controller/controller_rig.hpp"

namespace aprsim::robot {
namespace {

using api::ActionState;

class JointMoves : public testing::TestWithParam<const char*> {
 protected:
  JointMoves() : rig(GetParam()) { rig.run(api::InitRobot{}); }
  ControllerRig rig;
};
INSTANTIATE_TEST_SUITE_P(Arms, JointMoves, testing::Values("fanuc", "motoman"),
                         [](const auto& arm) { return std::string(arm.param); });

TEST_P(JointMoves, ReachEveryInRangeVectorExactlyWithinLimits) {
  std::mt19937 engine(5);
  for (int n = 0; n < 25; ++n) {
    const JointVector target = rig.random_posture(engine);
    rig.forget();
    ASSERT_EQ(rig.run(move_all(target)), ActionState::kDone) << rig.reason();
    ASSERT_EQ(rig.controller().reference(), target);
    ASSERT_FALSE(rig.controller().moving());
    const auto effort = rig.effort();
    EXPECT_LE(effort.speed, 1 + 1e-9);
    EXPECT_LE(effort.accel, 1 + 1e-9);
    EXPECT_LE(effort.jerk, 1 + 1e-3);
    EXPECT_LE(effort.tool_speed, rig.setup().max_trans_speed_m_s * 1.02);
  }
}

TEST_P(JointMoves, ReachTheLimitsThemselves) {
  for (const bool upper : {false, true}) {
    JointVector target(rig.dof());
    for (int i = 0; i < rig.dof(); ++i) {
      const Joint& joint = rig.model().joints[static_cast<std::size_t>(i)];
      target(i) = upper ? joint.upper_rad : joint.lower_rad;
    }
    ASSERT_EQ(rig.run(move_all(target)), ActionState::kDone) << rig.reason();
    EXPECT_EQ(rig.controller().reference(), target);
  }
}

TEST_P(JointMoves, GoStraightInJointSpaceAndArriveTogether) {
  const JointVector start = rig.controller().reference();
  JointVector target = start;
  target(0) += 0.5;
  target(1) += 0.2;
  rig.forget();
  ASSERT_EQ(rig.run(move_all(target)), ActionState::kDone);
  for (const JointVector& q : rig.path()) {
    EXPECT_NEAR((q(0) - start(0)) / 0.5, (q(1) - start(1)) / 0.2, 1e-12);
  }
}

TEST_P(JointMoves, RunNamedSpeedsAndLeaveOtherJointsAlone) {
  const JointVector start = rig.controller().reference();
  api::MoveJoints move;
  move.targets.push_back({0, start(0) + 0.8, 0.4, 2.0});
  move.targets.push_back({2, start(2) + 0.3, 0.1, {}});
  rig.forget();
  ASSERT_EQ(rig.run(move), ActionState::kDone) << rig.reason();
  double speed0 = 0, speed2 = 0, accel0 = 0;
  const auto& path = rig.path();
  for (std::size_t k = 2; k < path.size(); ++k) {
    speed0 = std::max(speed0, std::abs(path[k](0) - path[k - 1](0)) * 1e3);
    speed2 = std::max(speed2, std::abs(path[k](2) - path[k - 1](2)) * 1e3);
    accel0 = std::max(accel0, std::abs(path[k](0) - 2 * path[k - 1](0) + path[k - 2](0)) * 1e6);
    for (int i = 0; i < rig.dof(); ++i) {
      if (i == 0 || i == 2) continue;
      ASSERT_EQ(path[k](i), start(i));
    }
  }
  EXPECT_NEAR(speed0, 0.4, 1e-6);
  EXPECT_NEAR(speed2, 0.1, 1e-6);
  EXPECT_LE(accel0, 2.0 + 1e-6);
  EXPECT_EQ(rig.controller().reference()(0), start(0) + 0.8);
  EXPECT_EQ(rig.controller().reference()(2), start(2) + 0.3);
  // 0.3 rad at 0.1 rad/s and a little to start and stop.
  EXPECT_NEAR(static_cast<double>(path.size()) * 1e-3, 3.2, 0.3);
}

TEST_P(JointMoves, RefuseWithJointValueLimitAndUnit) {
  const Joint& joint = rig.model().joints[1];
  api::MoveJoints move;
  move.targets.push_back({1, joint.lower_rad - radians(10), {}, {}});
  ASSERT_EQ(rig.run(move), ActionState::kError);
  char expected[160];
  std::snprintf(expected, sizeof expected, "%s at %.1f deg is less than its limit %.1f deg",
                joint.name.c_str(), degrees(joint.lower_rad) - 10, degrees(joint.lower_rad));
  EXPECT_EQ(rig.reason(), expected);
  EXPECT_FALSE(rig.controller().moving());
  EXPECT_EQ(rig.controller().reference(), rig.setup().q_home);
}

TEST_P(JointMoves, RefuseAJointThatIsNamedTwice) {
  EXPECT_EQ(rig.run(api::MoveJoints{{{0, 0.1, {}, {}}, {0, 0.2, {}, {}}}}), ActionState::kError);
  EXPECT_NE(rig.reason().find("named twice"), std::string::npos);
}

TEST_P(JointMoves, MayGoWithWhereOtherJointsAreHeld) {
  ASSERT_EQ(rig.run(api::MoveJoints{{{0, 0.3, {}, {}}, {1, 0.2, {}, {}}}}), ActionState::kDone);
  // The third joint to 0.1 and a half of where the second is held, whatever that one's target is.
  api::MoveJoints move{{{1, 0.4, {}, {}}, {2, 0.1, {}, {}}}};
  move.targets[1].held = {{1, 0.5}, {0, 1}};
  ASSERT_EQ(rig.run(move), ActionState::kDone) << rig.reason();
  EXPECT_DOUBLE_EQ(rig.controller().reference()(1), 0.4);
  EXPECT_DOUBLE_EQ(rig.controller().reference()(2), 0.1 + 0.5 * 0.2 + 0.3);
  // The same in motion: the targets of the move that it replaces are what is held.
  rig.apply(api::MoveJoints{{{0, 0.5, {}, {}}}});
  rig.steps(30);
  api::MoveJoints after{{{2, 0.1, {}, {}}}};
  after.targets[0].held = {{0, 1}};
  ASSERT_EQ(rig.run(after), ActionState::kDone) << rig.reason();
  EXPECT_DOUBLE_EQ(rig.controller().reference()(0), 0.5);
  EXPECT_DOUBLE_EQ(rig.controller().reference()(2), 0.6);
  // Beyond the limits with what is held.
  after.targets[0].held = {{0, 100}};
  EXPECT_EQ(rig.run(after), ActionState::kError);
  EXPECT_NE(rig.reason().find(" is greater than its limit"), std::string::npos) << rig.reason();
}

TEST_P(JointMoves, NothingToDoIsDoneInTheNextStep) {
  const JointVector here = rig.controller().reference();
  rig.apply(move_all(here));
  EXPECT_EQ(rig.state(), ActionState::kWorking);
  rig.step();
  EXPECT_EQ(rig.state(), ActionState::kDone);
  EXPECT_EQ(rig.controller().reference(), here);
}

TEST_P(JointMoves, FreeMovesReachRandomPoses) {
  std::mt19937 engine(11);
  for (int n = 0; n < 25; ++n) {
    const Eigen::Isometry3d X = rig.X_RT(rig.random_posture(engine, 0.01));
    const Eigen::Isometry3d from = rig.X_RT(rig.controller().reference());
    rig.forget();
    ASSERT_EQ(rig.run(api::MoveTo{Pose::from(X), false}), ActionState::kDone) << rig.reason();
    const Eigen::Isometry3d reached = rig.X_RT(rig.controller().reference());
    EXPECT_LT((reached.translation() - X.translation()).norm(), 1e-9);
    EXPECT_LT((reached.linear() - X.linear()).norm(), 1e-9);
    const auto effort = rig.effort();
    EXPECT_LE(effort.speed, 1 + 1e-9);
    EXPECT_LE(effort.accel, 1 + 1e-9);
    EXPECT_LE(effort.jerk, 1 + 1e-3);
    EXPECT_LE(effort.tool_speed, 0.25 * 1.02);
    // The turn from end to end at the set rate; a wrist that unwinds may be faster on the way.
    const double turn = Eigen::AngleAxisd(from.linear().transpose() * X.linear()).angle();
    EXPECT_GE(static_cast<double>(rig.path().size() - 1) * 1e-3, turn / 1.0);
    EXPECT_LE(effort.tool_turn, 6.0 * 1.02);
  }
}

/// A short free move must not swing the elbow of a redundant arm, nor flip a wrist.
TEST_P(JointMoves, AShortFreeMoveTurnsTheJointsLittle) {
  std::mt19937 engine(13);
  std::uniform_real_distribution<double> shift(-5e-3, 5e-3);
  int moved = 0;
  for (int n = 0; n < 40; ++n) {
    ASSERT_EQ(rig.run(move_all(rig.random_posture(engine, 0.2))), ActionState::kDone);
    const JointVector start = rig.controller().reference();
    Eigen::Isometry3d X = rig.X_RT(start);
    EXPECT_EQ(rig.run(api::MoveTo{Pose::from(X), false}), ActionState::kDone);
    EXPECT_LE((rig.controller().reference() - start).norm(), 1e-6);
    // Away from singular postures, where a short way needs large turns.
    Eigen::MatrixXd J =
        point_jacobian(rig.model(), start, rig.dof(), rig.setup().X_FT.translation());
    J.topRows<3>() /= rig.dof() == 6 ? 0.25 : 0.4;
    if (Eigen::JacobiSVD<Eigen::MatrixXd>(J).singularValues().minCoeff() < 0.1) continue;
    X.translation() += Eigen::Vector3d(shift(engine), shift(engine), shift(engine));
    if (rig.run(api::MoveTo{Pose::from(X), false}) != ActionState::kDone) {
      rig.run(api::InitRobot{});
      continue;
    }
    ++moved;
    EXPECT_LE((rig.controller().reference() - start).cwiseAbs().maxCoeff(), 0.25) << n;
  }
  EXPECT_GE(moved, 15);
}

TEST_P(JointMoves, FreeMoveObeysTheSetSpeed) {
  ASSERT_EQ(rig.run(api::SetMotionLimit{api::MotionLimit::kTransSpeed, false, 0.1}),
            ActionState::kDone);
  Pose X = rig.tool();
  X.p.z() -= 0.05;
  X.p.x() -= 0.1;
  rig.forget();
  ASSERT_EQ(rig.run(api::MoveTo{X, false}), ActionState::kDone) << rig.reason();
  const auto effort = rig.effort();
  EXPECT_LE(effort.tool_speed, 0.1 * 1.02);
  EXPECT_GE(effort.tool_speed, 0.1 * 0.8);
}

TEST_P(JointMoves, UnreachablePoseIsRefusedWithTheReason) {
  Pose X = rig.tool();
  X.p.x() += 5;
  ASSERT_EQ(rig.run(api::MoveTo{X, false}), ActionState::kError);
  EXPECT_NE(rig.reason().find("out of reach by"), std::string::npos) << rig.reason();
}

TEST_P(JointMoves, SameCommandsGiveTheSameBits) {
  const auto drive = [&] {
    ControllerRig other(GetParam());
    std::mt19937 engine(3);
    other.run(api::InitRobot{});
    for (int n = 0; n < 4; ++n) {
      other.run(move_all(other.random_posture(engine)));
      other.run(api::MoveTo{Pose::from(other.X_RT(other.random_posture(engine, 0.1))), n % 2 == 0});
      other.run(api::InitRobot{});
    }
    return other.path();
  };
  const auto first = drive();
  const auto second = drive();
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t k = 0; k < first.size(); ++k) ASSERT_EQ(first[k], second[k]);
}

}  // namespace
}  // namespace aprsim::robot
