#include "world/physics/collision/speculative/look_ahead.hpp"

#include <gtest/gtest.h>

namespace aprsim::physics {
namespace {

TEST(StepsAhead, AreTwoUnlessABlowIsLookedForAnew) {
  EXPECT_EQ(steps_ahead(0), kStepsAhead);
  // One of two bodies with such a way between them has more than half of it.
  for (double way_m = 1e-7; way_m <= 2 * kStrikingWay; way_m += 1e-7) {
    EXPECT_EQ(steps_ahead(way_m), kStepsAhead) << way_m;
  }
  EXPECT_LT(steps_ahead(3 * kStrikingWay), kStepsAhead);
}

TEST(StepsAhead, TheFasterTheFartherAndNeverLessThanAStep) {
  double before = 0;
  for (double way_m = 1e-6; way_m < 0.1; way_m *= 1.01) {
    EXPECT_GT(steps_ahead(way_m), 1);
    EXPECT_GE(way_m * steps_ahead(way_m), before * (1 - 1e-12)) << way_m;
    before = way_m * steps_ahead(way_m);
  }
}

TEST(Way, OverSeveralStepsEndsWhereSoManyStepsLead) {
  const Moving body{{0.1, 0, 0}, {0.3, 0, -0.2}, {0, 4, 0}, 0.05}, still;
  const Way in_step = way_of(body, still, 1e-3);
  const Way ahead = in_step.over(kStepsAhead);
  EXPECT_EQ(in_step.steps, 1);
  EXPECT_EQ(ahead.steps, kStepsAhead);
  EXPECT_NEAR(ahead.longest_m(), kStepsAhead * in_step.longest_m(), 1e-15);
  EXPECT_TRUE(ahead.at(1 / ahead.steps).isApprox(in_step.at(1), 1e-12));
}

/// Of a body that sinks by 0.2 mm: contacts to the side, `deep_m` deep from `from_m` down, and one
/// under it, if it has a floor.
std::vector<Contact> ahead_of_sinking(double deep_m, double from_m, bool floor = false) {
  const Way way{.shift_W = {0, 0, -2e-4}};
  std::vector<Contact> found;
  find_ahead(way, 0, found, [&](const Eigen::Isometry3d& D) {
    if (D.translation().z() > from_m) return;
    found.push_back({.a = 0, .n_W = Eigen::Vector3d::UnitX(), .depth_m = deep_m});
    if (floor) found.push_back({.a = 0, .n_W = Eigen::Vector3d::UnitZ(), .depth_m = 1e-5});
  });
  return found;
}

TEST(FindAhead, DeepContactMustExistAtTheCurrentPose) {
  const auto stuck = ahead_of_sinking(8e-4, 1);
  ASSERT_EQ(stuck.size(), 1U);
  EXPECT_NEAR(stuck[0].depth_m, 8e-4, 1e-12);
  const auto entered = ahead_of_sinking(8e-4, -1e-5);
  ASSERT_EQ(entered.size(), 1U);
  EXPECT_EQ(entered[0].depth_m, 0);
  const auto beside = ahead_of_sinking(8e-4, -1e-5, true);
  ASSERT_EQ(beside.size(), 1U);
  EXPECT_EQ(beside[0].n_W.z(), 1);
}

TEST(FindAhead, ShallowContactCountsFromWhereItIsFound) {
  EXPECT_EQ(ahead_of_sinking(5e-5, -1e-5).size(), 1U);
}

}  // namespace
}  // namespace aprsim::physics
