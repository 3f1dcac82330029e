#include "world/physics/collision/look_ahead.hpp"

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

}  // namespace
}  // namespace aprsim::physics
