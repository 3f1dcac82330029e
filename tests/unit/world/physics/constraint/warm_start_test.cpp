#include "world/physics/constraint/warm_start.hpp"

#include <gtest/gtest.h>

#include "world/physics/constraint/impact_relaxation.hpp"

namespace aprsim::physics {
namespace {

using Eigen::Vector3d;

constexpr double kMass_kg = 0.1, kSpeed_m_s = 0.01, kNeeded_ns = kMass_kg * kSpeed_m_s;
const ContactSolverParameters kWarmStartParameters;

class WarmStartTest : public testing::Test {
 protected:
  /// A body that falls on a plane, with contacts under its centre.
  void state(int contacts, double last_ns, double change_ns) {
    const Twist free{{0, 0, -kSpeed_m_s}, Vector3d::Zero()};
    problem_.clear();
    const int body = problem_.add_body(kMass_kg, 1e-3 * Eigen::Matrix3d::Identity(),
                                       Vector3d::Zero(), free, free);
    for (int k = 0; k < contacts; ++k) {
      ContactDescription contact;
      contact.a = body;
      contact.impulse_ns = {last_ns * Vector3d::UnitZ(), change_ns * Vector3d::UnitZ()};
      problem_.add_contact(contact);
    }
    problem_.complete(kWarmStartParameters);
  }
  ContactProblem problem_;
  SavedImpulses saved_;
  ToleranceSchedule tolerance_{kWarmStartParameters, false};
};

TEST_F(WarmStartTest, ExtrapolatesWhereThatFits) {
  state(1, 0.5 * kNeeded_ns, 0.5 * kNeeded_ns);
  EXPECT_LT(warm_start(problem_, kWarmStartParameters, tolerance_, saved_).max_m_s(), 1e-12);
  EXPECT_DOUBLE_EQ(problem_.contact_impulse_ns(0).z(), kNeeded_ns);
}

TEST_F(WarmStartTest, TakesTheLastImpulsesWhereTheyFitBetter) {
  state(1, kNeeded_ns, 0.5 * kNeeded_ns);
  EXPECT_LT(warm_start(problem_, kWarmStartParameters, tolerance_, saved_).max_m_s(), 1e-12);
  EXPECT_DOUBLE_EQ(problem_.contact_impulse_ns(0).z(), kNeeded_ns);
}

TEST_F(WarmStartTest, ReturnsToTheExtrapolatedOnes) {
  state(1, 0.5 * kNeeded_ns, 0.4 * kNeeded_ns);
  const double residual_m_s =
      warm_start(problem_, kWarmStartParameters, tolerance_, saved_).max_m_s();
  EXPECT_NEAR(residual_m_s, 0.1 * kSpeed_m_s, 1e-12);
  EXPECT_DOUBLE_EQ(problem_.contact_impulse_ns(0).z(), 0.9 * kNeeded_ns);
  EXPECT_NEAR(problem_.twist(0).v.z(), -0.1 * kSpeed_m_s, 1e-12);
}

TEST_F(WarmStartTest, RelaxationSharesAnImpact) {
  state(5, 0, 0);
  const ContactResidual first = problem_.residual(kWarmStartParameters);
  ASSERT_TRUE(needs_relaxation(problem_, kWarmStartParameters, first));
  EXPECT_LT(relax_impact(problem_, kWarmStartParameters, tolerance_, first, saved_).max_m_s(),
            1e-12);
  for (int k = 0; k < 5; ++k) {
    EXPECT_DOUBLE_EQ(problem_.contact_impulse_ns(k).z(), kNeeded_ns / 5);
  }
}

TEST_F(WarmStartTest, ProblemsWithRowsAreNotRelaxed) {
  state(1, 0, 0);
  problem_.add_row({.body = 0, .linear = Vector3d::UnitX()}, {}, 0, 0, -1, 1);
  const ContactResidual first = problem_.residual(kWarmStartParameters);
  EXPECT_GT(first.max_m_s(), kWarmStartParameters.impact_residual_m_s);
  EXPECT_FALSE(needs_relaxation(problem_, kWarmStartParameters, first));
}

}  // namespace
}  // namespace aprsim::physics
