#include "world/physics/surface.hpp"

#include <gtest/gtest.h>

namespace aprsim::physics {
namespace {

Touch touch_of(SurfacePair pair) {
  Touch touch;
  touch.contact.pair = pair;
  touch.contact.depth_m = 1e-5;
  touch.friction = 0.6;
  return touch;
}

dContact described(const Touch& touch) {
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

}  // namespace
}  // namespace aprsim::physics
