#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/unit/world/robot/controller/controller_rig.hpp"

namespace aprsim::robot {
namespace {

using api::ActionState;

/// Largest distance of the tool point from the line, and of the orientation from the shortest turn.
struct Deviation {
  double position_m = 0, rotation_rad = 0, backwards = 0;
};

Deviation deviation(const ControllerRig& rig, const Eigen::Isometry3d& from,
                    const Eigen::Isometry3d& to) {
  Deviation out;
  const Eigen::Vector3d way = to.translation() - from.translation();
  const Eigen::AngleAxisd turn(from.linear().transpose() * to.linear());
  double last = 0;
  for (const JointVector& q : rig.path()) {
    const Eigen::Isometry3d X = rig.X_RT(q);
    const Eigen::Vector3d d = X.translation() - from.translation();
    const double share = way.norm() > 1e-9 ? d.dot(way) / way.squaredNorm() : 0;
    out.position_m = std::max(out.position_m, (d - share * way).norm());
    if (way.norm() > 1e-9) {
      const Eigen::Matrix3d R =
          from.linear() * Eigen::AngleAxisd(share * turn.angle(), turn.axis()).toRotationMatrix();
      out.rotation_rad = std::max(out.rotation_rad, (R - X.linear()).norm());
      out.backwards = std::max(out.backwards, last - share);
      last = share;
    }
  }
  return out;
}

class StraightMoves : public testing::TestWithParam<const char*> {
 protected:
  StraightMoves() : rig(GetParam()) {
    rig.run(api::InitRobot{});
    rig.run(move_all(working_posture()));
  }
  JointVector working_posture() const {
    JointVector q(rig.dof());
    if (rig.dof() == 6) {
      q << 0.2, 0.4, -0.4, 0.1, -0.9, 0.3;
    } else {
      q << 0.2, 0.5, 0.3, -1.4, 0.2, -1.0, 0.3;
    }
    return q;
  }
  ActionState straight(const Eigen::Isometry3d& X) {
    rig.forget();
    return rig.run(api::MoveTo{Pose::from(X), true});
  }
  ControllerRig rig;
};
INSTANTIATE_TEST_SUITE_P(Arms, StraightMoves, testing::Values("fanuc", "motoman"),
                         [](const auto& arm) { return std::string(arm.param); });

TEST_P(StraightMoves, StayOnTheLineWithinLimits) {
  std::mt19937 engine(21);
  std::uniform_real_distribution<double> shift(-0.12, 0.12), angle(-0.4, 0.4);
  const Eigen::Isometry3d centre = rig.X_RT(rig.controller().reference());
  int done = 0;
  for (int n = 0; n < 30; ++n) {
    const Eigen::Isometry3d from = rig.X_RT(rig.controller().reference());
    Eigen::Isometry3d to = centre;
    to.translation() += Eigen::Vector3d(shift(engine), shift(engine), shift(engine));
    to.linear() =
        to.linear() *
        Eigen::AngleAxisd(angle(engine),
                          Eigen::Vector3d(shift(engine), shift(engine), shift(engine)).normalized())
            .toRotationMatrix();
    const ActionState state = straight(to);
    if (state == ActionState::kError) {
      ASSERT_NE(rig.reason(), "");
      rig.run(api::InitRobot{});
      continue;
    }
    ++done;
    ASSERT_EQ(state, ActionState::kDone);
    const auto off = deviation(rig, from, to);
    ASSERT_LE(off.position_m, 1e-9);
    ASSERT_LE(off.rotation_rad, 1e-8);
    ASSERT_LE(off.backwards, 1e-9);
    const Eigen::Isometry3d reached = rig.X_RT(rig.controller().reference());
    ASSERT_LE((reached.translation() - to.translation()).norm(), 1e-9);
    ASSERT_LE((reached.linear() - to.linear()).norm(), 1e-9);
    const auto effort = rig.effort();
    ASSERT_LE(effort.speed, 1 + 1e-3);
    ASSERT_LE(effort.accel, 1.05);
    ASSERT_LE(effort.tool_speed, 0.25 * (1 + 1e-6));
    ASSERT_LE(effort.tool_accel, 2.0 * (1 + 1e-3));
    ASSERT_LE(effort.tool_turn, 1.0 * (1 + 1e-6));
  }
  EXPECT_GE(done, 28);
}

TEST_P(StraightMoves, RunAtTheSetSpeedAndTime) {
  Eigen::Isometry3d to = rig.X_RT(rig.controller().reference());
  to.translation().z() -= 0.1;
  ASSERT_EQ(straight(to), ActionState::kDone) << rig.reason();
  EXPECT_NEAR(rig.effort().tool_speed, 0.25, 1e-6);
  // 0.1 m at 0.25 m/s; reaching and leaving the speed takes 0.125 + 0.1 s.
  EXPECT_NEAR(static_cast<double>(rig.path().size() - 1) * 1e-3, 0.4 + 0.225, 2e-3);
}

TEST_P(StraightMoves, RotateAboutTheToolPoint) {
  const Eigen::Isometry3d from = rig.X_RT(rig.controller().reference());
  Eigen::Isometry3d to = from;
  to.linear() = to.linear() * Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  ASSERT_EQ(straight(to), ActionState::kDone) << rig.reason();
  for (const JointVector& q : rig.path()) {
    ASSERT_LE((rig.X_RT(q).translation() - from.translation()).norm(), 1e-9);
  }
  EXPECT_NEAR(rig.effort().tool_turn, 1.0, 1e-3);
}

TEST_P(StraightMoves, EndOutOfReachIsRefusedBeforeMoving) {
  Eigen::Isometry3d to = rig.X_RT(rig.controller().reference());
  to.translation().x() += 3;
  const JointVector here = rig.controller().reference();
  ASSERT_EQ(straight(to), ActionState::kError);
  EXPECT_NE(rig.reason().find("out of reach by"), std::string::npos) << rig.reason();
  rig.steps(10);
  EXPECT_EQ(rig.controller().reference(), here);
}

/// From one side to the other past the arm's own column: both ends can be reached, the way not.
TEST_P(StraightMoves, WayOutOfReachIsRefusedBeforeMoving) {
  const Eigen::Isometry3d from = rig.X_RT(rig.controller().reference());
  const Eigen::Isometry3d X_BR = rig.setup().X_BR;
  const Eigen::Isometry3d half_turn(Eigen::AngleAxisd(radians(150), Eigen::Vector3d::UnitZ()));
  const Eigen::Isometry3d to = X_BR.inverse() * half_turn * X_BR * from;
  const JointVector here = rig.controller().reference();
  ASSERT_EQ(straight(to), ActionState::kError);
  EXPECT_NE(rig.reason().find("straight line"), std::string::npos) << rig.reason();
  rig.steps(10);
  EXPECT_EQ(rig.controller().reference(), here);
  rig.run(api::InitRobot{});
  EXPECT_EQ(rig.run(api::MoveTo{Pose::from(to), false}), ActionState::kDone) << rig.reason();
}

TEST_P(StraightMoves, LeaveHome) {
  rig.run(move_all(rig.setup().q_home));
  for (const Eigen::Vector3d& d :
       {Eigen::Vector3d(0, 0, -0.1), Eigen::Vector3d(0.05, 0, 0), Eigen::Vector3d(0, 0.08, 0),
        Eigen::Vector3d(-0.1, -0.1, 0), Eigen::Vector3d(0, 0, 0.05)}) {
    rig.run(move_all(rig.setup().q_home));
    const Eigen::Isometry3d from = rig.X_RT(rig.controller().reference());
    Eigen::Isometry3d to = from;
    to.translation() += d;
    ASSERT_EQ(straight(to), ActionState::kDone) << rig.reason() << d.transpose();
    EXPECT_LE(deviation(rig, from, to).position_m, 1e-9);
    const auto effort = rig.effort();
    EXPECT_LE(effort.speed, 1 + 1e-3);
    EXPECT_LE(effort.accel, 1.05);
  }
}

/// A straight wrist with its axes 4 and 6 in line: going sideways needs axis 4 turned first, which
/// the tool does not notice.
/// From home to the other side with the tool turned by exactly half a turn: one way round axis T
/// runs into its limit, the other one does not.
TEST(StraightMovesMotoman, HalfATurnGoesRoundTheFreeWay) {
  ControllerRig rig("motoman");
  rig.run(api::InitRobot{});
  for (const double side : {1.0, -1.0}) {
    ASSERT_EQ(rig.run(move_all(rig.setup().q_home)), ActionState::kDone);
    Eigen::Isometry3d X_BT = Eigen::Isometry3d::Identity();
    X_BT.translation() = Eigen::Vector3d(-0.18, side * 0.64, 0.05);
    X_BT.linear() = Eigen::AngleAxisd(radians(180), Eigen::Vector3d::UnitX()).toRotationMatrix();
    const Eigen::Isometry3d from = rig.X_RT(rig.controller().reference());
    const Eigen::Isometry3d to = rig.setup().X_BR.inverse() * X_BT;
    rig.forget();
    ASSERT_EQ(rig.run(api::MoveTo{Pose::from(to), true}), ActionState::kDone) << rig.reason();
    EXPECT_LE(deviation(rig, from, to).position_m, 1e-9);
    EXPECT_LE((rig.X_RT(rig.controller().reference()).linear() - to.linear()).norm(), 1e-9);
  }
}

TEST(StraightMovesFanuc, LeaveASingularPostureByTurningTheFreeAxesFirst) {
  for (const double bend : {0.0, 1e-5, 1e-3, 0.1}) {
    ControllerRig rig("fanuc");
    rig.run(api::InitRobot{});
    JointVector q(6);
    q << 0.1, 0.4, -0.3, 0.2, bend, 0.3;
    rig.run(move_all(q));
    const Eigen::Isometry3d from = rig.X_RT(q);
    Eigen::Isometry3d to = from;
    to.translation() += Eigen::Vector3d(0.02, 0.1, 0);
    rig.forget();
    ASSERT_EQ(rig.run(api::MoveTo{Pose::from(to), true}), ActionState::kDone)
        << bend << " " << rig.reason();
    const auto off = deviation(rig, from, to);
    EXPECT_LE(off.position_m, 1e-9) << bend;
    EXPECT_LE(off.rotation_rad, 1e-8) << bend;
    EXPECT_LE((rig.X_RT(rig.controller().reference()).translation() - to.translation()).norm(),
              1e-9);
    const auto effort = rig.effort();
    EXPECT_LE(effort.speed, 1 + 1e-2) << bend;
    EXPECT_LE(effort.accel, 1.05) << bend;
    EXPECT_LE(rig.path().size(), 4000u) << bend;
  }
}

TEST(StraightMovesFanuc, ReplacementWhileTheFreeAxesTurn) {
  ControllerRig rig("fanuc");
  rig.run(api::InitRobot{});
  JointVector q(6);
  q << 0.1, 0.4, -0.3, 0.2, 0.0, 0.3;
  rig.run(move_all(q));
  const Eigen::Isometry3d from = rig.X_RT(q);
  Eigen::Isometry3d to = from;
  to.translation() += Eigen::Vector3d(0, 0.1, 0);
  rig.forget();
  rig.apply(api::MoveTo{Pose::from(to), true});
  rig.steps(100);
  ASSERT_LE((rig.X_RT(rig.controller().reference()).translation() - from.translation()).norm(),
            1e-9);
  ASSERT_EQ(rig.run(api::StopMotion{}), ActionState::kDone);
  EXPECT_LE((rig.X_RT(rig.controller().reference()).translation() - from.translation()).norm(),
            1e-9);
  const JointVector stopped = rig.controller().reference();
  rig.steps(20);
  EXPECT_EQ(rig.controller().reference(), stopped);
  ASSERT_EQ(rig.run(api::MoveTo{Pose::from(to), true}), ActionState::kDone) << rig.reason();
  EXPECT_LE(deviation(rig, from, to).position_m, 1e-9);
  const auto effort = rig.effort();
  EXPECT_LE(effort.accel, 1.05);
}

TEST(StraightMovesFanuc, PassTheWristSingularitySlowed) {
  // A line across the front with the flange tilted by eps: the wrist passes eps from straight.
  for (const double eps : {0.0, 0.01, 0.1, 0.5, 1.0, 2.0, 3.0, 5.0}) {
    ControllerRig rig("fanuc");
    rig.run(api::InitRobot{});
    const auto flange_at = [&](double y) {
      Eigen::Isometry3d X_BF = Eigen::Isometry3d::Identity();
      X_BF.translation() = Eigen::Vector3d(0.465, y, 0.695);
      X_BF.linear() = Eigen::AngleAxisd(radians(eps), Eigen::Vector3d::UnitY()).toRotationMatrix();
      return Eigen::Isometry3d(rig.setup().X_BR.inverse() * X_BF * rig.setup().X_FT);
    };
    const Eigen::Isometry3d from = flange_at(-0.15), to = flange_at(0.15);
    ASSERT_EQ(rig.run(api::MoveTo{Pose::from(from), false}), ActionState::kDone) << rig.reason();
    rig.forget();
    ASSERT_EQ(rig.run(api::MoveTo{Pose::from(to), true}), ActionState::kDone)
        << eps << " " << rig.reason();
    const auto off = deviation(rig, from, to);
    EXPECT_LE(off.position_m, 1e-9) << eps;
    EXPECT_LE(off.backwards, 1e-9) << eps;
    const auto effort = rig.effort();
    EXPECT_LE(effort.speed, 1 + 1e-2) << eps;
    EXPECT_LE(effort.accel, 1.1) << eps;
    EXPECT_LE(effort.jerk, 1.5) << eps;
    // 1.43 s without slowing; turning axis 4 by 180 deg takes the rest.
    EXPECT_LE(rig.path().size(), 6000u) << eps;
  }
}

}  // namespace
}  // namespace aprsim::robot
