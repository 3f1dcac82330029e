#include "world/physics/surface.hpp"

#include <gtest/gtest.h>

namespace aprsim::physics {
namespace {

Touch touch_of(SurfacePair pair) {
  Touch touch;
  touch.contact.pair = pair;
  touch.contact.depth_m = 1e-5;
  touch.friction = 0.6;
  touch.normal_n = 50;
  return touch;
}

dContact described(const Touch& touch, Friction friction) {
  return ode_contact(touch, friction, false, Eigen::Vector3d::UnitX(), 0, Eigen::Vector3d::Zero());
}

TEST(Surface, PadsAreSofterThanAnythingElse) {
  const dContact pad = described(touch_of(SurfacePair::kPadGear), Friction::kFixed);
  for (const auto pair :
       {SurfacePair::kGearTray, SurfacePair::kGearGear, SurfacePair::kGearGround,
        SurfacePair::kTrayBelt, SurfacePair::kTrayGround, SurfacePair::kRobotAny}) {
    const dContact other = described(touch_of(pair), Friction::kFixed);
    EXPECT_GE(pad.surface.soft_cfm, 10 * other.surface.soft_cfm);
    EXPECT_TRUE(other.surface.mode & dContactSoftCFM);
  }
  EXPECT_TRUE(pad.surface.mode & dContactSoftCFM);
  EXPECT_TRUE(pad.surface.mode & dContactSoftERP);
}

TEST(Surface, AKnownNormalForceFixesTheFrictionBound) {
  const Touch touch = touch_of(SurfacePair::kGearTray);
  const dContact fixed = described(touch, Friction::kFixed);
  EXPECT_DOUBLE_EQ(fixed.surface.mu, 30);
  EXPECT_FALSE(fixed.surface.mode & dContactApprox1);
  const dContact pyramid = described(touch, Friction::kPyramid);
  EXPECT_DOUBLE_EQ(pyramid.surface.mu, 0.6);
  EXPECT_TRUE(pyramid.surface.mode & dContactApprox1);
}

}  // namespace
}  // namespace aprsim::physics
