#include "world/physics/constraint/tolerance_schedule.hpp"

#include <gtest/gtest.h>

namespace aprsim::physics {
namespace {

const ContactSolverParameters kScheduleParameters;

TEST(ToleranceSchedule, RelaxesTenfoldInADecadeUpToItsMaximum) {
  const ToleranceSchedule tolerance(kScheduleParameters, false);
  EXPECT_EQ(tolerance.after(0), 1e-8);
  EXPECT_EQ(tolerance.after(20), 1e-8);
  EXPECT_DOUBLE_EQ(tolerance.after(32), 1e-7);
  EXPECT_DOUBLE_EQ(tolerance.after(44), 1e-6);
  EXPECT_EQ(tolerance.after(1000), kScheduleParameters.max_tolerance_m_s);
}

TEST(ToleranceSchedule, IsSmallerAtRest) {
  EXPECT_DOUBLE_EQ(ToleranceSchedule(kScheduleParameters, true).after(0), 1e-9);
}

TEST(ToleranceSchedule, OnlyContactsOfUnactuatedBodiesHaveASlack) {
  ContactSolverParameters parameters;
  parameters.relaxed_tolerance_m_s = 1e-4;
  const ToleranceSchedule tolerance(parameters, false);
  EXPECT_TRUE(tolerance.accepts({.actuated_m_s = 1e-8, .relaxed_m_s = 0.9e-4}, 0));
  EXPECT_FALSE(tolerance.accepts({.actuated_m_s = 2e-8, .relaxed_m_s = 0}, 0));
  EXPECT_FALSE(tolerance.accepts({.actuated_m_s = 0, .relaxed_m_s = 1.1e-4}, 0));
}

}  // namespace
}  // namespace aprsim::physics
