#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/unit/world/robot/controller/controller_rig.hpp"

namespace aprsim::robot {
namespace {

using api::ActionState;
using Eigen::Vector3d;

class ScrewMoves : public testing::TestWithParam<const char*> {
 protected:
  ScrewMoves() : rig(GetParam()) {
    rig.ready();
    start = rig.X_RT(rig.controller().reference());
    axis = start.linear().col(2);
  }
  ControllerRig rig;
  Eigen::Isometry3d start;
  Vector3d axis;
};
INSTANTIATE_TEST_SUITE_P(Arms, ScrewMoves, testing::Values("fanuc", "motoman"),
                         [](const auto& arm) { return std::string(arm.param); });

/// Turn and advance belong together at every instant, and the turn is right-handed about the tool's
/// z axis, along which a positive advance goes.
TEST_P(ScrewMoves, TurnsAndAdvancesTogetherAboutTheToolsAxis) {
  for (const double sign : {1.0, -1.0}) {
    const Eigen::Isometry3d from = rig.X_RT(rig.controller().reference());
    rig.forget();
    const api::MoveScrew screw{.screw_m = 0.02 * sign, .turn_rad = 2.5 * sign};
    ASSERT_EQ(rig.run(screw), ActionState::kDone) << rig.reason();
    for (const JointVector& q : rig.path()) {
      const Eigen::Isometry3d X = rig.X_RT(q);
      const Vector3d way = X.translation() - from.translation();
      const double advance = way.dot(axis);
      ASSERT_LE((way - advance * axis).norm(), 1e-9);
      const Eigen::Matrix3d turned =
          Eigen::AngleAxisd(2.5 / 0.02 * advance, axis).toRotationMatrix() * from.linear();
      ASSERT_LE((turned - X.linear()).norm(), 1e-6);
    }
    const Eigen::Isometry3d end = rig.X_RT(rig.controller().reference());
    EXPECT_LE((end.translation() - from.translation() - 0.02 * sign * axis).norm(), 1e-9);
    EXPECT_LE(rig.effort().speed, 1.001);
    EXPECT_LE(rig.effort().accel, 1.05);
    EXPECT_LE(rig.effort().tool_turn, 1.0 * 1.001);
  }
}

TEST_P(ScrewMoves, RevolvesAboutAnAxisPointAtTheSetSpeed) {
  const Vector3d point = start.translation() + 0.03 * start.linear().col(0);
  const api::MoveScrew screw{
      .start = {}, .axis_point_R = point, .free_m = 0, .screw_m = 0.01, .turn_rad = 2};
  rig.run(api::SetMotionLimit{api::MotionLimit::kTransSpeed, false, 0.02});
  ASSERT_EQ(rig.run(screw), ActionState::kDone) << rig.reason();
  double fastest = 0;
  for (std::size_t k = 1; k < rig.path().size(); ++k) {
    const Vector3d p = rig.X_RT(rig.path()[k]).translation();
    const Vector3d arm = p - point;
    ASSERT_NEAR((arm - arm.dot(axis) * axis).norm(), 0.03, 1e-9);
    fastest = std::max(fastest,
                       (p - rig.X_RT(rig.path()[k - 1]).translation()).norm() / rig.setup().step_s);
  }
  EXPECT_NEAR(fastest, 0.02, 1e-4);
  const Vector3d end = rig.tool().p - point;
  const Vector3d expected =
      Eigen::AngleAxisd(2, axis) * Vector3d(start.translation() - point) + 0.01 * axis;
  EXPECT_LE((end - expected).norm(), 1e-9);
}

TEST_P(ScrewMoves, GoesToItsStartAndAdvancesFreelyFirst) {
  Eigen::Isometry3d X = start;
  X.translation() += Vector3d(0.03, -0.04, 0.02);
  api::MoveScrew screw{.start = api::Waypoint{Pose::from(X)},
                       .axis_point_R = {},
                       .free_m = 0.015,
                       .screw_m = 0.01,
                       .turn_rad = -1.5};
  ASSERT_EQ(rig.run(screw), ActionState::kDone) << rig.reason();
  const Vector3d end = X.translation() + 0.025 * axis;
  EXPECT_LE((rig.tool().p - end).norm(), 1e-9);
  double at_start = 1e9, at_free_end = 1e9;
  for (const JointVector& q : rig.path()) {
    const Eigen::Isometry3d here = rig.X_RT(q);
    if ((here.linear() - X.linear()).norm() > 1e-6) continue;
    at_start = std::min(at_start, (here.translation() - X.translation()).norm());
    at_free_end =
        std::min(at_free_end, (here.translation() - X.translation() - 0.015 * axis).norm());
  }
  EXPECT_LE(at_start, 1e-9);
  EXPECT_LE(at_free_end, 1e-9);
  EXPECT_LT(rig.effort().jerk, 2);
}

/// The start may be taken in a posture that leaves the last joint enough of its range.
TEST_P(ScrewMoves, ChoosesAStartPostureThatHasTheTurnLeft) {
  JointVector q = rig.controller().reference();
  const int last = rig.dof() - 1;
  const Joint& joint = rig.model().joints[static_cast<std::size_t>(last)];
  // Near the end that the turn runs into.
  q(last) = joint.lower_rad + 0.3;
  ASSERT_EQ(rig.run(move_all(q)), ActionState::kDone);
  const Pose here = rig.tool();
  int refused = 0, made = 0;
  for (const double turn : {3.0, -3.0}) {
    rig.run(move_all(q));
    if (rig.run(api::MoveScrew{.screw_m = 0.001, .turn_rad = turn}) == ActionState::kError) {
      ++refused;
      EXPECT_NE(rig.reason().find("would pass its limit"), std::string::npos) << rig.reason();
      EXPECT_NE(rig.reason().find("% of the screw"), std::string::npos) << rig.reason();
      rig.run(api::InitRobot{});
    }
    if (rig.run(api::MoveScrew{.start = api::Waypoint{here}, .screw_m = 0.001, .turn_rad = turn}) ==
        ActionState::kDone) {
      ++made;
    } else {
      rig.run(api::InitRobot{});
    }
  }
  EXPECT_EQ(refused, 1);
  EXPECT_EQ(made, 2);
}

TEST_P(ScrewMoves, RefusedBeforeMoving) {
  const JointVector here = rig.controller().reference();
  EXPECT_EQ(rig.run(api::MoveScrew{.screw_m = 3, .turn_rad = 1}), ActionState::kError);
  EXPECT_NE(rig.reason(), "");
  rig.steps(10);
  EXPECT_EQ(rig.controller().reference(), here);
  rig.run(api::InitRobot{});
  Eigen::Isometry3d X = start;
  X.translation().z() += 0.05;
  EXPECT_EQ(
      rig.run(api::MoveScrew{
          .start = api::Waypoint{Pose::from(X)}, .free_m = 4, .screw_m = 0.01, .turn_rad = 1}),
      ActionState::kError);
  EXPECT_EQ(rig.reason().rfind("free advance of the screw: ", 0), 0u) << rig.reason();
  EXPECT_EQ(rig.controller().reference(), here);
}

TEST_P(ScrewMoves, StopsOnTheHelix) {
  for (const auto kind : {api::StopKind::kFast, api::StopKind::kNormal}) {
    rig.run(api::MoveTo{Pose::from(start), true});
    rig.apply(api::MoveScrew{.screw_m = 0.02, .turn_rad = 2.5});
    rig.steps(900);
    rig.apply(api::StopMotion{kind});
    rig.rest();
    const Eigen::Isometry3d X = rig.X_RT(rig.controller().reference());
    const Vector3d way = X.translation() - start.translation();
    const double advance = way.dot(axis);
    EXPECT_GT(advance, 1e-3);
    EXPECT_LT(advance, 0.019);
    EXPECT_LE((way - advance * axis).norm(), 1e-9);
    const Eigen::Matrix3d turned =
        Eigen::AngleAxisd(2.5 / 0.02 * advance, axis).toRotationMatrix() * start.linear();
    EXPECT_LE((turned - X.linear()).norm(), 1e-6);
  }
}

}  // namespace
}  // namespace aprsim::robot
