#include "world/physics/constraint/contact_material.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace aprsim::physics {
namespace {

constexpr double kStep_s = 1e-3;

ContactConstraint constraint_of(SurfacePair pair, double depth_m = 1e-5) {
  ContactConstraint constraint;
  constraint.contact.pair = pair;
  constraint.contact.depth_m = depth_m;
  constraint.contact.n_W = Eigen::Vector3d::UnitZ();
  constraint.friction = 0.6;
  return constraint;
}

ContactResponse response_of(const ContactConstraint& constraint, double belt_speed_m_s = 0) {
  return contact_response(constraint, false, Eigen::Vector3d::UnitX(), belt_speed_m_s, kStep_s);
}

TEST(ContactMaterial, PadsAreSofterThanAnythingElse) {
  const double pad = response_of(constraint_of(SurfacePair::kPadGear)).cfm;
  for (const auto pair :
       {SurfacePair::kGearTray, SurfacePair::kGearGear, SurfacePair::kGearGround,
        SurfacePair::kTrayBelt, SurfacePair::kTrayGround, SurfacePair::kRobotAny}) {
    EXPECT_GE(pad, 10 * response_of(constraint_of(pair)).cfm);
    EXPECT_GT(response_of(constraint_of(pair)).cfm, 0);
  }
}

TEST(ContactMaterial, DeepPenetrationEndsNoFasterThanItMay) {
  for (const double depth : {1e-4, 1e-3, 1e-2, 1.0}) {
    const double rate = response_of(constraint_of(SurfacePair::kGearTray, depth)).target_v_W.z();
    EXPECT_GT(rate, 0);
    EXPECT_LE(rate * kStep_s, depth);
    EXPECT_LE(rate, 0.5);
  }
}

TEST(ContactMaterial, AGapMayCloseWithinTheStep) {
  const ContactConstraint gap = constraint_of(SurfacePair::kPadGear, -2e-4);
  ASSERT_TRUE(is_gap(gap));
  EXPECT_DOUBLE_EQ(response_of(gap).target_v_W.z() * kStep_s, -2e-4);
}

/// The belt's surface moves as the belt does, in the contact's plane.
TEST(ContactMaterial, TheBeltMovesAlongItsAxis) {
  ContactConstraint constraint = constraint_of(SurfacePair::kTrayBelt);
  constraint.belt = true;
  for (const double speed : {-0.4, 0.0, 0.4}) {
    const Eigen::Vector3d v = response_of(constraint, speed).target_v_W;
    EXPECT_DOUBLE_EQ(v.x(), speed);
    EXPECT_DOUBLE_EQ(v.y(), 0);
  }
  constraint.contact.n_W = Eigen::Vector3d::UnitX();  // the belt's end
  EXPECT_DOUBLE_EQ(response_of(constraint, 0.4).target_v_W.tail<2>().norm(), 0);
}

}  // namespace
}  // namespace aprsim::physics
