#include "world/physics/collision/speculative/speculative_contacts.hpp"

#include <gtest/gtest.h>

namespace aprsim::physics {
namespace {

TEST(LookaheadSteps, AreTwoUnlessAnImpactIsRechecked) {
  EXPECT_EQ(lookahead_steps(0), kLookaheadSteps);
  // One of two bodies with this relative displacement has at least half of it.
  for (double displacement_m = 1e-7; displacement_m <= 2 * kImpactDisplacement;
       displacement_m += 1e-7) {
    EXPECT_EQ(lookahead_steps(displacement_m), kLookaheadSteps) << displacement_m;
  }
  EXPECT_LT(lookahead_steps(3 * kImpactDisplacement), kLookaheadSteps);
}

TEST(LookaheadSteps, CoverMoreDistanceTheFasterAndAtLeastAStep) {
  double before = 0;
  for (double displacement_m = 1e-6; displacement_m < 0.1; displacement_m *= 1.01) {
    EXPECT_GT(lookahead_steps(displacement_m), 1);
    EXPECT_GE(displacement_m * lookahead_steps(displacement_m), before * (1 - 1e-12))
        << displacement_m;
    before = displacement_m * lookahead_steps(displacement_m);
  }
}

TEST(Displacement, ScaledBySeveralStepsEndsAtTheMotionOfThese) {
  const BodyVelocity body{{0.1, 0, 0}, {0.3, 0, -0.2}, {0, 4, 0}, 0.05}, still;
  const Displacement in_step = relative_displacement(body, still, 1e-3);
  const Displacement ahead = in_step.scaled(kLookaheadSteps);
  EXPECT_EQ(in_step.steps, 1);
  EXPECT_EQ(ahead.steps, kLookaheadSteps);
  EXPECT_NEAR(ahead.max_m(), kLookaheadSteps * in_step.max_m(), 1e-15);
  EXPECT_TRUE(ahead.at(1 / ahead.steps).isApprox(in_step.at(1), 1e-12));
}

/// Speculative contacts of a body that sinks by 0.2 mm: one to the side, `deep_m` deep from
/// `from_m` down, and one under it, if it has a floor.
std::vector<Contact> ahead_of_sinking(double deep_m, double from_m, bool floor = false) {
  const Displacement sinking{.translation_W = {0, 0, -2e-4}};
  std::vector<Contact> found;
  find_speculative_contacts(sinking, 0, found, [&](const Eigen::Isometry3d& D) {
    if (D.translation().z() > from_m) return;
    found.push_back({.a = 0, .n_W = Eigen::Vector3d::UnitX(), .depth_m = deep_m});
    if (floor) found.push_back({.a = 0, .n_W = Eigen::Vector3d::UnitZ(), .depth_m = 1e-5});
  });
  return found;
}

TEST(SpeculativeContacts, DeepContactMustExistAtTheCurrentPose) {
  const auto existing = ahead_of_sinking(8e-4, 1);
  ASSERT_EQ(existing.size(), 1U);
  EXPECT_NEAR(existing[0].depth_m, 8e-4, 1e-12);
  const auto entered = ahead_of_sinking(8e-4, -1e-5);
  ASSERT_EQ(entered.size(), 1U);
  EXPECT_EQ(entered[0].depth_m, 0);
  const auto beside = ahead_of_sinking(8e-4, -1e-5, true);
  ASSERT_EQ(beside.size(), 1U);
  EXPECT_EQ(beside[0].n_W.z(), 1);
}

TEST(SpeculativeContacts, ShallowContactCountsFromWhereItIsFound) {
  EXPECT_EQ(ahead_of_sinking(5e-5, -1e-5).size(), 1U);
}

}  // namespace
}  // namespace aprsim::physics
