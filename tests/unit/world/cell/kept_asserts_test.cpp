#include "world/cell/kept_asserts.hpp"

#include <algorithm>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "world/physics/bodies/ode_geoms.hpp"
#include "world/physics/bodies/physics_failure.hpp"
#include "world/robot/kinematics/dynamics.hpp"

namespace aprsim::world {
namespace {

bool keeps(const std::string& whose) {
  const auto kept = kept_asserts();
  return std::ranges::find(kept, whose) != kept.end();
}

/// A release build keeps the assertions that it reports.
TEST(KeptAssertsDeathTest, OursAbort) {
  if (!keeps("aprsim")) GTEST_SKIP() << "built without";
  EXPECT_DEATH((void)robot::flange_pose(robot::ArmModel{}, Eigen::VectorXd::Zero(3)), "Assertion");
}

TEST(KeptAssertsDeathTest, EigensAbort) {
  if (!keeps("Eigen")) GTEST_SKIP() << "built without";
  EXPECT_DEATH(
      {
        Eigen::VectorXd two = Eigen::VectorXd::Zero(2);
        two(5) = 1;
      },
      "Assertion");
}

TEST(KeptAsserts, OdesThrow) {
  if (!keeps("ODE")) GTEST_SKIP() << "linked with one that has none";
  EXPECT_THROW((void)physics::OdeGeom::sphere(-1), physics::PhysicsFailure);
}

/// The builds that are shipped and tested keep them all.
TEST(KeptAsserts, AreAllOfThem) {
  EXPECT_EQ(kept_asserts(), (std::vector<std::string>{"aprsim", "Eigen", "ODE"}));
}

}  // namespace
}  // namespace aprsim::world
