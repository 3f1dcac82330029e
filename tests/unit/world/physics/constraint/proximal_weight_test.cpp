#include "world/physics/constraint/proximal_weight.hpp"

#include <gtest/gtest.h>

namespace aprsim::physics {
namespace {

const ContactSolverParameters kWeightParameters;
constexpr double kSlow = 0.5;  // contraction

TEST(ProximalWeight, StartsWithTheResidualWithinItsBounds) {
  EXPECT_EQ(ProximalWeight(kWeightParameters, 0).value(),
            kWeightParameters.min_initial_proximal_weight);
  EXPECT_DOUBLE_EQ(ProximalWeight(kWeightParameters, 1e-4).value(), 0.01);
  const ProximalWeight far(kWeightParameters, 1);
  EXPECT_EQ(far.value(), kWeightParameters.max_proximal_weight);
  EXPECT_TRUE(far.is_max());
}

TEST(ProximalWeight, DecreasesAfterAnEasySubproblemThatContractedSlowly) {
  ProximalWeight weight(kWeightParameters, 1e-4);
  weight.adapt(kWeightParameters.easy_subproblem_newton_steps + 1, kSlow);
  weight.adapt(1, 0.5 * kWeightParameters.fast_contraction);
  EXPECT_DOUBLE_EQ(weight.value(), 0.01);
  weight.adapt(kWeightParameters.easy_subproblem_newton_steps, kSlow);
  EXPECT_DOUBLE_EQ(weight.value(), 0.001);
  for (int i = 0; i < 100; ++i) weight.adapt(1, kSlow);
  EXPECT_EQ(weight.value(), kWeightParameters.min_proximal_weight);
}

TEST(ProximalWeight, IsCautiousAfterAFailure) {
  ProximalWeight weight(kWeightParameters, 1e-4);
  weight.increase();
  EXPECT_DOUBLE_EQ(weight.value(), 0.05);
  EXPECT_FALSE(weight.is_max());
  weight.adapt(1, kSlow);
  EXPECT_DOUBLE_EQ(weight.value(), 0.01);
  for (int i = 0; i < 100; ++i) weight.increase();
  EXPECT_TRUE(weight.is_max());
}

}  // namespace
}  // namespace aprsim::physics
