#include "world/physics/constraint/contact_material.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace aprsim::physics {
namespace {

ContactConstraint touch_of(SurfacePair pair) {
  ContactConstraint touch;
  touch.contact.pair = pair;
  touch.contact.depth_m = 1e-5;
  touch.friction = 0.6;
  return touch;
}

dContact described(const ContactConstraint& touch) {
  return ode_contact(touch, false, Eigen::Vector3d::UnitX(), 0, Eigen::Vector3d::Zero());
}

TEST(Surface, PadsAreSofterThanAnythingElse) {
  const dContact pad = described(touch_of(SurfacePair::kPadGear));
  for (const auto pair :
       {SurfacePair::kGearTray, SurfacePair::kGearGear, SurfacePair::kGearGround,
        SurfacePair::kTrayBelt, SurfacePair::kTrayGround, SurfacePair::kRobotAny}) {
    const dContact other = described(touch_of(pair));
    EXPECT_GE(pad.surface.soft_cfm, 10 * other.surface.soft_cfm);
    EXPECT_TRUE(other.surface.mode & dContactSoftCFM);
  }
  EXPECT_TRUE(pad.surface.mode & dContactSoftCFM);
  EXPECT_TRUE(pad.surface.mode & dContactSoftERP);
}

TEST(Surface, FrictionFollowsTheNormalForce) {
  const dContact contact = described(touch_of(SurfacePair::kGearTray));
  EXPECT_DOUBLE_EQ(contact.surface.mu, 0.6);
  EXPECT_TRUE(contact.surface.mode & dContactApprox1);
}

/// Whatever way the pyramid is turned, the belt's surface moves as the belt does.
TEST(Surface, TheBeltMovesAlikeInEveryDirectionOfSliding) {
  ContactConstraint touch = touch_of(SurfacePair::kTrayBelt);
  touch.belt = true;
  touch.contact.n_W = Eigen::Vector3d::UnitZ();
  for (const double turn : {0.0, 0.3, 1.57, 2.5, -1.0}) {
    const Eigen::Vector3d slide(2 * std::cos(turn), 2 * std::sin(turn), 0);
    const dContact contact = ode_contact(touch, false, Eigen::Vector3d::UnitX(), 0.4, slide);
    const Eigen::Vector3d t1(contact.fdir1[0], contact.fdir1[1], contact.fdir1[2]);
    const Eigen::Vector3d t2 = touch.contact.n_W.cross(t1);
    const Eigen::Vector3d v = contact.surface.motion1 * t1 + contact.surface.motion2 * t2;
    EXPECT_NEAR((t1 - slide / 2).norm(), 0, 1e-15);
    EXPECT_NEAR((v - Eigen::Vector3d(0.4, 0, 0)).norm(), 0, 1e-15) << turn;
  }
}

}  // namespace
}  // namespace aprsim::physics
