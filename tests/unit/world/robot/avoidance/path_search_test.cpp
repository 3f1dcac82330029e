#include "world/robot/avoidance/path_search.hpp"

#include <algorithm>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/world/robot/avoidance/walled_arm.hpp"

namespace aprsim::robot {
namespace {

using test::WalledArm;

/// An arm that turns from one side of a wall to the other.
struct OverTheWall {
  explicit OverTheWall(double height_m) {
    walled.add_gripper(model);
    walled.add_box("wall", {1, 0.02, height_m}, {0.75, 0, 0.5 * height_m - 0.01});
    start = goal = test::home(model);
    start(0) = -0.8;
    goal(0) = 0.8;
  }
  ArmModel model = test::fanuc();
  JointLimits limits = derive_joint_limits(model, {}, {0, 0, -9.81});
  WalledArm walled;
  JointVector start, goal;
};

std::vector<JointVector> find(const OverTheWall& way, const PathSearchEffort& effort) {
  CollisionChecker checker(way.model, way.walled.around);
  const auto ends = checker.set_ends(way.start, way.goal);
  EXPECT_TRUE(ends.has_value()) << ends.error().message;
  EXPECT_FALSE(checker.is_free(way.start, way.goal));
  PathSearch search(checker, way.limits);
  std::vector<JointVector> path = search.find(way.start, way.goal, effort);
  EXPECT_TRUE(path.empty() || checker.is_free(PostureCurve(path)));
  return path;
}

double length(const OverTheWall& way, const std::vector<JointVector>& path) {
  CollisionChecker checker(way.model, way.walled.around);
  return PathSearch(checker, way.limits).length(path);
}

TEST(PathSearch, FindsAWayOverAWall) {
  const OverTheWall way(0.65);
  const std::vector<JointVector> path = find(way, {});
  ASSERT_GE(path.size(), 3U);
  EXPECT_EQ(path.front(), way.start);
  EXPECT_EQ(path.back(), way.goal);
}

/// OMPL's own generators have other seeds each time.
TEST(PathSearch, GivesTheSameBitsEachTime) {
  const OverTheWall way(0.65);
  const auto first = find(way, {}), again = find(way, {});
  ASSERT_EQ(first.size(), again.size());
  for (std::size_t i = 0; i < first.size(); ++i) EXPECT_EQ(first[i], again[i]) << i;
  EXPECT_NE(find(way, {.seed = 2}), first);
}

TEST(PathSearch, MoreAttemptsFindNoLongerPaths) {
  const OverTheWall way(0.65);
  const double one = length(way, find(way, {.attempts = 1}));
  const double many = length(way, find(way, {.attempts = 8, .good_length = 0}));
  EXPECT_GT(many, 0);
  EXPECT_LE(many, one);
}

/// Attempts end with the first path that is good enough.
TEST(PathSearch, IsContentWithAGoodPath) {
  bool content = false, discontent = false;
  for (const double wall_m : {0.63, 0.65, 0.68, 0.7}) {
    const OverTheWall way(wall_m);
    const double straight = length(way, {way.start, way.goal});
    const double first = length(way, find(way, {.attempts = 1}));
    const double best = length(way, find(way, {.attempts = 8, .good_length = 0}));
    ASSERT_GT(best, straight);
    for (const double good : {1.0, 1.1, 1.2, 1.3, 1.5, 2.0}) {
      const double found = length(way, find(way, {.attempts = 8, .good_length = good}));
      const bool at_once = first <= good * straight;
      EXPECT_TRUE(at_once ? found == first : found <= std::max(best, good * straight)) << wall_m;
      (at_once ? content : discontent) = true;
    }
  }
  EXPECT_TRUE(content && discontent);
}

TEST(PathSearch, EndsWithoutAPathWhereThereIsNone) {
  OverTheWall way(3);
  // Walls all round.
  way.walled.add_box("roof", {3, 3, 0.02}, {0, 0, 1.0});
  way.walled.add_box("blade", {0.9, 0.02, 3}, {0.62, 0, 1.49});
  way.walled.add_box("rear blade", {0.9, 0.02, 3}, {-0.62, 0, 1.49});
  EXPECT_TRUE(find(way, {.iterations = 200, .attempts = 1}).empty());
}

TEST(PathSearch, EndsAfterSoManyPostures) {
  const OverTheWall way(0.65);
  CollisionChecker checker(way.model, way.walled.around);
  ASSERT_TRUE(checker.set_ends(way.start, way.goal).has_value());
  PathSearch search(checker, way.limits);
  EXPECT_TRUE(search.find(way.start, way.goal, {.evaluations = 0}).empty());
  EXPECT_LT(checker.evaluations(), 2000U);
}

TEST(PathSearch, GivesUpWhenItIsCancelled) {
  const OverTheWall way(0.65);
  CollisionChecker checker(way.model, way.walled.around);
  ASSERT_TRUE(checker.set_ends(way.start, way.goal).has_value());
  const std::atomic<bool> cancelled{true};
  EXPECT_TRUE(PathSearch(checker, way.limits, &cancelled).find(way.start, way.goal, {}).empty());
}

}  // namespace
}  // namespace aprsim::robot
