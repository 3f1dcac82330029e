#include "world/physics/constraint/contact_material.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace aprsim::physics {
namespace {

ContactConstraint constraint_of(SurfacePair pair) {
  ContactConstraint constraint;
  constraint.contact.pair = pair;
  constraint.contact.depth_m = 1e-5;
  constraint.friction = 0.6;
  return constraint;
}

dContact described(const ContactConstraint& constraint) {
  return ode_contact(constraint, contact_response(constraint, false, Eigen::Vector3d::UnitX(), 0));
}

TEST(ContactMaterial, PadsAreSofterThanAnythingElse) {
  const dContact pad = described(constraint_of(SurfacePair::kPadGear));
  for (const auto pair :
       {SurfacePair::kGearTray, SurfacePair::kGearGear, SurfacePair::kGearGround,
        SurfacePair::kTrayBelt, SurfacePair::kTrayGround, SurfacePair::kRobotAny}) {
    const dContact other = described(constraint_of(pair));
    EXPECT_GE(pad.surface.soft_cfm, 10 * other.surface.soft_cfm);
    EXPECT_TRUE(other.surface.mode & dContactSoftCFM);
  }
  EXPECT_TRUE(pad.surface.mode & dContactSoftCFM);
  EXPECT_TRUE(pad.surface.mode & dContactSoftERP);
}

TEST(ContactMaterial, FrictionFollowsTheNormalForce) {
  const dContact contact = described(constraint_of(SurfacePair::kGearTray));
  EXPECT_DOUBLE_EQ(contact.surface.mu, 0.6);
  EXPECT_TRUE(contact.surface.mode & dContactApprox1);
}

/// Whatever way the pyramid is turned, the belt's surface moves as the belt does.
TEST(ContactMaterial, TheBeltMovesAlikeInEveryDirectionOfSliding) {
  ContactConstraint constraint = constraint_of(SurfacePair::kTrayBelt);
  constraint.belt = true;
  constraint.contact.n_W = Eigen::Vector3d::UnitZ();
  for (const double turn : {0.0, 0.3, 1.57, 2.5, -1.0}) {
    const Eigen::Vector3d slide(2 * std::cos(turn), 2 * std::sin(turn), 0);
    const dContact contact = ode_contact(
        constraint, contact_response(constraint, false, Eigen::Vector3d::UnitX(), 0.4, slide));
    const Eigen::Vector3d t1(contact.fdir1[0], contact.fdir1[1], contact.fdir1[2]);
    const Eigen::Vector3d t2 = constraint.contact.n_W.cross(t1);
    const Eigen::Vector3d v = contact.surface.motion1 * t1 + contact.surface.motion2 * t2;
    EXPECT_NEAR((t1 - slide / 2).norm(), 0, 1e-15);
    EXPECT_NEAR((v - Eigen::Vector3d(0.4, 0, 0)).norm(), 0, 1e-15) << turn;
  }
}

}  // namespace
}  // namespace aprsim::physics
