#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/unit/world/robot/controller/controller_rig.hpp"

namespace aprsim::robot {
namespace {

using api::ActionState;
using Eigen::Vector3d;

/// Moves past waypoints, from a posture with room all round.
class ThroughMoves : public testing::TestWithParam<const char*> {
 protected:
  ThroughMoves() : rig(GetParam()) {
    rig.ready();
    home = rig.X_RT(rig.controller().reference());
  }
  api::Waypoint at(const Vector3d& shift, double turn = 0, double tolerance_m = 5e-3) const {
    Eigen::Isometry3d X = home;
    X.translation() += shift;
    X.linear() = X.linear() * Eigen::AngleAxisd(turn, Vector3d::UnitZ()).toRotationMatrix();
    api::Waypoint point{Pose::from(X)};
    point.tolerance = {tolerance_m, tolerance_m, tolerance_m, 0.02, 0.02};
    return point;
  }
  /// A square with a detour; every corner is one.
  std::vector<api::Waypoint> square(double tolerance_m) const {
    return {at({0.08, 0, 0}, 0.1, tolerance_m), at({0.08, 0.08, 0}, 0.2, tolerance_m),
            at({0, 0.08, -0.04}, 0, tolerance_m), at({0, 0, 0}, 0, tolerance_m)};
  }

  struct Approach {
    double outside = 1e9;   ///< least distance beyond the tolerance box over the path
    double distance = 1e9;  ///< least distance
    double slowest = 1e9;   ///< least tool speed at the nearest point
  };
  Approach approach(const api::Waypoint& point) const {
    Approach out;
    const auto& path = rig.path();
    for (std::size_t k = 1; k < path.size(); ++k) {
      const Eigen::Isometry3d X = rig.X_RT(path[k]);
      const Vector3d off = (X.translation() - point.X_RT.p).cwiseAbs();
      const Eigen::Matrix3d R = point.X_RT.q.toRotationMatrix();
      const double turn = std::max(std::acos(std::min(1.0, X.linear().col(0).dot(R.col(0)))),
                                   std::acos(std::min(1.0, X.linear().col(2).dot(R.col(2)))));
      const double outside =
          std::max({off.x() - *point.tolerance.x_m, off.y() - *point.tolerance.y_m,
                    off.z() - *point.tolerance.z_m, turn - 0.02});
      out.outside = std::min(out.outside, outside);
      if (off.norm() < out.distance) {
        out.distance = off.norm();
        out.slowest = (X.translation() - rig.X_RT(path[k - 1]).translation()).norm() * 1e3;
      }
    }
    return out;
  }
  /// Tool speeds over the path, without the ends.
  double slowest_in_between() const {
    double slowest = 1e9;
    const auto& path = rig.path();
    for (std::size_t k = 300; k + 300 < path.size(); ++k) {
      slowest = std::min(
          slowest,
          (rig.X_RT(path[k]).translation() - rig.X_RT(path[k - 1]).translation()).norm() * 1e3);
    }
    return slowest;
  }
  ControllerRig rig;
  Eigen::Isometry3d home;
};
INSTANTIATE_TEST_SUITE_P(Arms, ThroughMoves, testing::Values("fanuc", "motoman"),
                         [](const auto& arm) { return std::string(arm.param); });

TEST_P(ThroughMoves, PassEveryWaypointWithinItsToleranceWithoutStopping) {
  for (const bool straight : {true, false}) {
    for (const double tolerance : {2e-3, 8e-3}) {
      SCOPED_TRACE(testing::Message() << "straight " << straight << " tolerance " << tolerance);
      rig.forget();
      const auto points = square(tolerance);
      ASSERT_EQ(rig.run(api::MoveThroughTo{points, straight}), ActionState::kDone) << rig.reason();
      for (std::size_t i = 0; i + 1 < points.size(); ++i) {
        const Approach nearest = approach(points[i]);
        EXPECT_LE(nearest.outside, 1e-9) << i;
        EXPECT_GT(nearest.slowest, 0.02) << i;
        EXPECT_GT(nearest.distance, 1e-5) << i;
      }
      EXPECT_GT(slowest_in_between(), 0.02);
      EXPECT_LE((rig.tool().p - points.back().X_RT.p).norm(), 1e-9);
      const auto effort = rig.effort();
      EXPECT_LE(effort.speed, 1.001);
      EXPECT_LE(effort.accel, 1.05);
      EXPECT_LE(effort.jerk, 1.6);
      EXPECT_LE(effort.tool_speed, 0.25 * 1.02);
      EXPECT_LE(effort.tool_accel, 2.0 * 1.05);
    }
  }
}

TEST_P(ThroughMoves, StaysOnTheLinesBetweenTheCorners) {
  const auto points = square(2e-3);
  rig.forget();
  ASSERT_EQ(rig.run(api::MoveThroughTo{points, true}), ActionState::kDone) << rig.reason();
  std::vector<Vector3d> corners{home.translation()};
  for (const auto& point : points) corners.push_back(point.X_RT.p);
  for (const JointVector& q : rig.path()) {
    const Vector3d p = rig.X_RT(q).translation();
    double off = 1e9, corner = 1e9;
    for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
      const Vector3d way = corners[i + 1] - corners[i];
      const double share = std::clamp((p - corners[i]).dot(way) / way.squaredNorm(), 0.0, 1.0);
      off = std::min(off, (p - corners[i] - share * way).norm());
      corner = std::min(corner, (p - corners[i + 1]).norm());
    }
    ASSERT_LE(off, corner < 0.02 ? 3.5e-3 : 1e-9);
  }
}

TEST_P(ThroughMoves, WithoutToleranceItStopsAtTheWaypoint) {
  for (const bool straight : {true, false}) {
    auto points = square(0);
    rig.forget();
    ASSERT_EQ(rig.run(api::MoveThroughTo{points, straight}), ActionState::kDone) << rig.reason();
    for (const auto& point : points) EXPECT_LE(approach(point).distance, 1e-9);
  }
}

TEST_P(ThroughMoves, WiderToleranceIsQuicker) {
  std::size_t last = 1u << 30;
  for (const double tolerance : {1e-4, 1e-3, 4e-3, 16e-3}) {
    rig.forget();
    ASSERT_EQ(rig.run(api::MoveThroughTo{square(tolerance), true}), ActionState::kDone);
    EXPECT_LT(rig.path().size(), last) << tolerance;
    last = rig.path().size();
  }
  rig.forget();
  ASSERT_EQ(rig.run(api::MoveThroughTo{square(0), true}), ActionState::kDone);
  EXPECT_GT(rig.path().size(), last);
}

TEST_P(ThroughMoves, EachWayHasItsOwnSpeed) {
  auto points = square(5e-3);
  points[1].limits.trans_speed = api::LimitSetting{false, 0.05};
  rig.forget();
  ASSERT_EQ(rig.run(api::MoveThroughTo{points, true}), ActionState::kDone) << rig.reason();
  double first = 0, second = 0;
  const auto& path = rig.path();
  for (std::size_t k = 1; k < path.size(); ++k) {
    const Vector3d p = rig.X_RT(path[k]).translation();
    const double speed = (p - rig.X_RT(path[k - 1]).translation()).norm() * 1e3;
    const Vector3d off = p - home.translation();
    if (off.x() < 0.05 && off.y() < 1e-6) first = std::max(first, speed);
    if (off.x() > 0.08 - 1e-6 && off.y() > 0.03 && off.y() < 0.05) second = std::max(second, speed);
  }
  EXPECT_GT(first, 0.1);
  EXPECT_LE(second, 0.05 * 1.001);
  EXPECT_GT(second, 0.045);
}

/// A circle in 300 short pieces runs as one motion.
TEST_P(ThroughMoves, ManyWaypointsMakeOneSmoothMotion) {
  std::vector<api::Waypoint> points;
  for (int i = 1; i <= 300; ++i) {
    const double angle = radians(1.2 * i);
    points.push_back(at({0.05 * std::sin(angle), 0.05 - 0.05 * std::cos(angle), 0}, 0, 1e-4));
  }
  rig.forget();
  ASSERT_EQ(rig.run(api::MoveThroughTo{points, true}), ActionState::kDone) << rig.reason();
  EXPECT_GT(slowest_in_between(), 0.02);
  const Vector3d centre = home.translation() + Vector3d(0, 0.05, 0);
  for (const JointVector& q : rig.path()) {
    ASSERT_NEAR((rig.X_RT(q).translation() - centre).norm(), 0.05, 1.1e-4);
  }
  EXPECT_LE(rig.effort().accel, 1.05);
}

TEST_P(ThroughMoves, IsRefusedAsAWholeBeforeMoving) {
  const JointVector here = rig.controller().reference();
  for (const bool straight : {true, false}) {
    auto points = square(5e-3);
    points[2].X_RT.p.x() += 3;
    ASSERT_EQ(rig.run(api::MoveThroughTo{points, straight}), ActionState::kError);
    EXPECT_EQ(rig.reason().rfind("waypoint 3 of 4: out of reach by", 0), 0u) << rig.reason();
    rig.steps(20);
    EXPECT_EQ(rig.controller().reference(), here);
    rig.run(api::InitRobot{});
  }
}

TEST_P(ThroughMoves, StopsOnTheWayAlsoInACorner) {
  for (const int steps : {300, 380, 420, 460, 700}) {
    for (const auto kind : {api::StopKind::kFast, api::StopKind::kNormal}) {
      rig.run(api::MoveTo{Pose::from(home), true});
      // The path that a run to the end takes.
      rig.forget();
      rig.run(api::MoveThroughTo{square(8e-3), true});
      const std::vector<JointVector> whole = rig.path();
      rig.run(api::MoveTo{Pose::from(home), true});
      rig.forget();
      rig.apply(api::MoveThroughTo{square(8e-3), true});
      rig.steps(steps);
      rig.apply(api::StopMotion{kind});
      rig.rest();
      EXPECT_EQ(rig.state(), ActionState::kDone);
      const Vector3d stopped = rig.tool().p;
      double off = 1e9;
      for (std::size_t k = 1; k < whole.size(); ++k) {
        const Vector3d a = rig.X_RT(whole[k - 1]).translation(),
                       b = rig.X_RT(whole[k]).translation();
        const double share =
            std::clamp((stopped - a).dot(b - a) / std::max((b - a).squaredNorm(), 1e-18), 0.0, 1.0);
        off = std::min(off, (stopped - a - share * (b - a)).norm());
      }
      EXPECT_LE(off, 1e-6) << steps;
      EXPECT_GT((stopped - home.translation()).norm(), 1e-3);
    }
  }
}

TEST_P(ThroughMoves, DoubledWaypointsAndOneThatIsHereAreFine) {
  auto points = square(5e-3);
  points.insert(points.begin(), at({0, 0, 0}));
  points.insert(points.begin() + 2, points[1]);
  rig.forget();
  ASSERT_EQ(rig.run(api::MoveThroughTo{points, true}), ActionState::kDone) << rig.reason();
  EXPECT_LE((rig.tool().p - points.back().X_RT.p).norm(), 1e-9);
  EXPECT_GT(slowest_in_between(), 0.02);
  ASSERT_EQ(rig.run(api::MoveThroughTo{{at({0, 0, 0}), at({0, 0, 0})}, true}), ActionState::kDone);
}

}  // namespace
}  // namespace aprsim::robot
