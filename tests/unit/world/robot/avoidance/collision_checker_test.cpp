#include "world/robot/avoidance/collision_checker.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/world/robot/avoidance/walled_arm.hpp"
#include "world/robot/kinematics/dynamics.hpp"

namespace aprsim::robot {
namespace {

using test::WalledArm;

/// Least distance of any moving shape from any obstacle at a posture.
double least_distance(const ArmModel& model, const Surroundings& around, const JointVector& q) {
  std::vector<Eigen::Isometry3d> X_BL(model.links.size());
  link_poses(model, q, X_BL);
  double least = 1e9;
  const auto measure = [&](const ConvexShape& shape, const Eigen::Isometry3d& X_BS) {
    for (const Obstacle& each : around.obstacles) {
      least = std::min(least, distance_bound(shape, X_BS, each.shape, each.X_BS, least));
    }
  };
  for (std::size_t link = 1; link < model.links.size(); ++link) {
    for (const LinkShape& each : model.links[link].collision) {
      measure(convex_shape(each.shape), X_BL[link] * each.X_LS);
    }
  }
  for (const CarriedShape& each : around.carried) measure(each.shape, X_BL.back() * each.X_FS);
  return least;
}

/// The same on the whole way between two postures, whose points lie so close that nothing travels
/// farther than `spacing_m` between them.
double least_distance_between(const ArmModel& model, const Surroundings& around,
                              const JointVector& from, const JointVector& to, double spacing_m) {
  constexpr double kReach_m = 1.3;  // of any point from any axis
  const double travel_m = kReach_m * (to - from).cwiseAbs().sum();
  const int count = std::max(1, static_cast<int>(std::ceil(travel_m / spacing_m)));
  double least = 1e9;
  for (int i = 0; i <= count; ++i) {
    const double share = static_cast<double>(i) / count;
    least = std::min(least, least_distance(model, around, from + share * (to - from)));
    if (least < 0) break;
  }
  return least;
}

struct Arm {
  const char* name;
  ArmModel (*load)();
};
void PrintTo(const Arm& arm, std::ostream* os) { *os << arm.name; }

class CollisionCheckerOf : public testing::TestWithParam<Arm> {
 protected:
  ArmModel model_ = GetParam().load();
  std::mt19937_64 random_{11};
  double unit() { return std::uniform_real_distribution<double>(0, 1)(random_); }
  /// A posture from one by up to so much in each joint.
  JointVector near(const JointVector& q, double by_rad) {
    JointVector to = q;
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      const Joint& joint = model_.joints[static_cast<std::size_t>(i)];
      to(i) = std::clamp(q(i) + by_rad * (2 * unit() - 1), joint.lower_rad, joint.upper_rad);
    }
    return to;
  }
};
INSTANTIATE_TEST_SUITE_P(Arms, CollisionCheckerOf,
                         testing::Values(Arm{"fanuc", test::fanuc}, Arm{"motoman", test::motoman}),
                         [](const auto& arm) { return std::string(arm.param.name); });

/// No motion passes through a wall of 0.2 mm, and those that the checker lets pass keep the
/// clearance: measured at points so close that no wall fits between them.
TEST_P(CollisionCheckerOf, NothingThinIsPassedThrough) {
  constexpr double kThin_m = 2e-4, kClearance_m = 2e-3, kSpacing_m = 4e-3;
  int free = 0, blocked = 0, through = 0;
  for (int i = 0; i < 200 && (free < 60 || through < 25); ++i) {
    WalledArm walled(kClearance_m);
    walled.around.obstacles.clear();
    walled.add_gripper(model_);
    walled.around.self_collision = false;
    for (int wall = 0; wall < 3; ++wall) {
      const double angle = 6.2831853 * unit(), radius = 0.25 + 0.5 * unit();
      walled.add_box("wall", {0.3 + unit(), kThin_m, 0.3 + unit()},
                     {radius * std::cos(angle), radius * std::sin(angle), 0.8 * unit()},
                     6.2831853 * unit());
    }
    CollisionChecker checker(model_, walled.around);
    for (int k = 0; k < 8; ++k) {
      const JointVector from = test::random_q(model_, random_, 0.6), to = near(from, 1.5);
      if (!checker.set_ends(from, to)) continue;
      if (least_distance(model_, walled.around, from) < kClearance_m ||
          least_distance(model_, walled.around, to) < kClearance_m) {
        continue;
      }
      const double least = least_distance_between(model_, walled.around, from, to, kSpacing_m);
      if (checker.is_free(from, to)) {
        ++free;
        EXPECT_GT(least, kClearance_m - 4e-4) << i << " " << k;
      } else {
        ++blocked;
        if (least < 0) ++through;
        // It is not blocked without a reason.
        EXPECT_LT(least, kClearance_m + kSpacing_m) << i << " " << k;
      }
    }
  }
  EXPECT_GE(free, 60);
  EXPECT_GE(blocked, 25);
  EXPECT_GE(through, 25);
}

TEST_P(CollisionCheckerOf, TheFirstTouchOfACurveIsNamed) {
  WalledArm walled;
  walled.add_gripper(model_);
  const JointVector home = test::home(model_);
  JointVector turned = home;
  turned(0) = 2.0;
  walled.add_box("wall", {2, 0.01, 3}, {1.05, 0.4, 0.5});
  walled.add_box("second wall", {2, 0.01, 3}, {1.05, 0.45, 0.5});
  CollisionChecker checker(model_, walled.around);
  ASSERT_TRUE(checker.set_ends(home, turned).has_value());
  const auto touch = checker.first_touch(PostureCurve({home, turned}));
  ASSERT_TRUE(touch);
  EXPECT_EQ(touch->other, "wall");
  EXPECT_GT(touch->u, 0);
  EXPECT_LT(touch->u, 0.6);
  // All before is free.
  const JointVector before = home + (touch->u - 0.02) * (turned - home);
  EXPECT_TRUE(checker.is_free(home, before));
}

TEST_P(CollisionCheckerOf, ABlockedEndIsNamed) {
  WalledArm walled;
  walled.add_gripper(model_);
  const JointVector home = test::home(model_);
  JointVector goal = home;
  goal(0) = 1;
  const Eigen::Vector3d p = flange_pose(model_, goal).translation();
  walled.add_box("post", {0.05, 0.05, 0.05}, p);
  CollisionChecker checker(model_, walled.around);
  const auto blocked = checker.set_ends(home, goal);
  ASSERT_FALSE(blocked);
  EXPECT_EQ(blocked.error().field, "goal");
  EXPECT_NE(blocked.error().message.find("the goal is blocked: "), std::string::npos);
  EXPECT_NE(blocked.error().message.find(" touches post"), std::string::npos);
  const auto start = checker.set_ends(goal, home);
  ASSERT_FALSE(start);
  EXPECT_EQ(start.error().field, "start");
}

/// A gripper between parts closer than the clearance may go there and away, but touch nothing.
TEST_P(CollisionCheckerOf, WhatIsNearAtTheGoalMayBeNear) {
  WalledArm walled(0.02);
  walled.add_gripper(model_);
  const JointVector goal = test::home(model_);
  JointVector start = goal;
  start(1) -= 0.3;
  const Eigen::Isometry3d X_BF = flange_pose(model_, goal);
  const Eigen::Vector3d side =
      X_BF * WalledArm::approach(model_, 0.1) * Eigen::Vector3d(0, 0.04 + 0.01 + 0.005, 0);
  walled.add_box("peg", {0.02, 0.02, 0.02}, side, 0, Obstacle::Kind::kPart);
  CollisionChecker checker(model_, walled.around);
  ASSERT_TRUE(checker.set_ends(start, goal).has_value());
  EXPECT_TRUE(checker.is_free(goal));
  // The same posture between other ends is too near.
  JointVector elsewhere = start;
  elsewhere(0) += 0.5;
  ASSERT_TRUE(checker.set_ends(start, elsewhere).has_value());
  EXPECT_FALSE(checker.is_free(goal));
}

/// A held part in a pocket, which shapes do not have, may leave along the normal only.
TEST(CollisionChecker, AHeldPartLeavesItsPlaceSteeply) {
  const ArmModel model = test::fanuc();
  WalledArm walled;
  const JointVector start = test::home(model);
  const Eigen::Isometry3d X_BF = flange_pose(model, start);
  walled.add_carried(model, "gear", {0.02, 0.04, 0.04}, 0.1, true);
  // The gear's lower 6 mm are inside of the tray.
  const Eigen::Vector3d bottom = X_BF * Eigen::Vector3d(0.11, 0, 0);
  walled.add_box("tray", {0.3, 0.3, 0.02}, bottom + Eigen::Vector3d(0, 0, 0.006 - 0.01), 0,
                 Obstacle::Kind::kPart);
  CollisionChecker checker(model, walled.around);
  JointVector along = start, up = start;
  along(0) += 0.1;
  // Upwards: the tool moves up as the shoulder goes back, nearly along the vertical.
  const Jacobian J = point_jacobian(model, start, model.dof(), Eigen::Vector3d(0.1, 0, 0));
  Eigen::Matrix<double, 6, 1> rise = Eigen::Matrix<double, 6, 1>::Zero();
  rise(2) = 0.03;
  up += J.completeOrthogonalDecomposition().solve(rise);
  ASSERT_TRUE(checker.set_ends(start, up).has_value());
  EXPECT_TRUE(checker.is_free(start, up));
  ASSERT_TRUE(checker.set_ends(start, start).has_value());
  EXPECT_FALSE(checker.is_free(start, along));
}

TEST_P(CollisionCheckerOf, OwnLinksCollide) {
  WalledArm walled;
  walled.around.obstacles.clear();
  walled.add_gripper(model_, 0.3);
  CollisionChecker checker(model_, walled.around);
  const JointVector home = test::home(model_);
  ASSERT_TRUE(checker.set_ends(home, home).has_value());
  EXPECT_TRUE(checker.is_free(home));
  int touching = 0;
  for (int i = 0; i < 1000; ++i) {
    if (!checker.is_free(test::random_q(model_, random_))) ++touching;
  }
  EXPECT_GT(touching, 5);
  walled.around.self_collision = false;
  CollisionChecker without(model_, walled.around);
  ASSERT_TRUE(without.set_ends(home, home).has_value());
  EXPECT_TRUE(without.is_free(test::random_q(model_, random_)));
}

}  // namespace
}  // namespace aprsim::robot
