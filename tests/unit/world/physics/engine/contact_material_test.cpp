#include "world/physics/engine/contact_material.hpp"

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
  return contact_response(constraint, {.belt_speed_m_s = belt_speed_m_s, .step_s = kStep_s});
}

TEST(ContactMaterial, PadsAreSofterThanAnythingElse) {
  const double pad = response_of(constraint_of(SurfacePair::kPadGear)).compliance_m_s_n;
  for (const auto pair :
       {SurfacePair::kGearTray, SurfacePair::kGearGear, SurfacePair::kGearGround,
        SurfacePair::kTrayBelt, SurfacePair::kTrayGround, SurfacePair::kRobotAny}) {
    EXPECT_GE(pad, 10 * response_of(constraint_of(pair)).compliance_m_s_n);
    EXPECT_GT(response_of(constraint_of(pair)).compliance_m_s_n, 0);
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

double normal_speed_after(const ContactConstraint& constraint, const ContactSetting& setting) {
  const ContactResponse response = contact_response(constraint, setting);
  return response.target_v_W.z() + response.rebound_m_s;
}

/// From the surface and from a gap that closes in the step, thrown and falling: a body rises to e^2
/// of the height from which it has come.
TEST(ContactMaterial, ReboundsToTheShareOfTheHeight) {
  constexpr double kGravity = 9.81, kRestitution = 0.7, kHeight = 0.3;
  for (int start = 0; start < 20; ++start) {
    ContactConstraint constraint = constraint_of(SurfacePair::kGearGround);
    constraint.restitution = kRestitution;
    double z = kHeight + 1e-4 * start, v = 0, top = 0;
    const double height = z;
    bool struck = false;
    for (int step = 0; step < 2000; ++step) {
      constraint.contact.depth_m = -z;
      const double free = v - kGravity * kStep_s;
      double next = free;
      if (!struck && z + kStep_s * free <= 0) {
        next = normal_speed_after(
            constraint, {.step_s = kStep_s, .normal_speed_m_s = v, .normal_accel_m_s2 = -kGravity});
        struck = true;
      }
      v = next;
      z += kStep_s * v;
      if (struck) top = std::max(top, z);
      if (struck && v < 0) break;
    }
    EXPECT_NEAR(top, kRestitution * kRestitution * height, 2e-5);
  }
}

TEST(ContactMaterial, SlowApproachesGiveNothingBack) {
  ContactConstraint constraint = constraint_of(SurfacePair::kGearGround, 0);
  constraint.restitution = 0.9;
  const auto rate = [&](double speed) {
    return normal_speed_after(constraint, {.step_s = kStep_s, .normal_speed_m_s = -speed});
  };
  EXPECT_LE(rate(0.02), 0);
  EXPECT_NEAR(rate(0.5), 0.45, 1e-12);
}

}  // namespace
}  // namespace aprsim::physics
