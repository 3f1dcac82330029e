#include "world/physics/gripper/gripper_actuator.hpp"

#include <gtest/gtest.h>

namespace aprsim::physics {
namespace {

constexpr double kClosed = 0.01, kStep = 1e-3;
constexpr std::array<FingerMotion, 2> kMiddle = {FingerMotion{5e-3, 0}, FingerMotion{5e-3, 0}};

scene::Gripper gripper(scene::GripperDrive drive) {
  scene::Gripper out;
  out.drive = drive;
  out.force_n = 60;
  out.finger_speed_m_s = 0.1;
  return out;
}

TEST(GripperActuator, APistonKnowsTwoSettings) {
  GripperActuator actuator(gripper(scene::GripperDrive::kPneumatic));
  EXPECT_FALSE(actuator.command(1));
  EXPECT_FALSE(actuator.command(0.6));  // open, as it is
  EXPECT_TRUE(actuator.command(0.4));
  EXPECT_TRUE(actuator.is_closing());
  EXPECT_EQ(actuator.stop_travel_m(kClosed), kClosed);
}

TEST(GripperActuator, AServoStopsAnywhere) {
  GripperActuator actuator(gripper(scene::GripperDrive::kServo));
  EXPECT_TRUE(actuator.command(0.25));
  EXPECT_FALSE(actuator.command(0.25));
  EXPECT_DOUBLE_EQ(actuator.stop_travel_m(kClosed), 0.75 * kClosed);
  EXPECT_TRUE(actuator.is_at_full_force());
}

TEST(GripperActuator, WearSlowsOneFingerAndSmoothsThePads) {
  GripperActuator actuator(gripper(scene::GripperDrive::kPneumatic));
  const double friction = actuator.pad_friction();
  const GripperWear wear{.pad_friction = 0.5, .finger_speed = {1, 0.25}};
  EXPECT_TRUE(actuator.set_wear(wear));
  EXPECT_FALSE(actuator.set_wear(wear));
  EXPECT_DOUBLE_EQ(actuator.pad_friction(), 0.5 * friction);
  EXPECT_TRUE(actuator.command(0));
  const auto drives = actuator.advance(kMiddle, kClosed, kStep);
  EXPECT_GT(drives[0].speed_m_s, 0);
  EXPECT_DOUBLE_EQ(drives[1].speed_m_s, 0.25 * drives[0].speed_m_s);
}

TEST(GripperActuator, WithoutAirNothingPushes) {
  GripperActuator actuator(gripper(scene::GripperDrive::kPneumatic));
  EXPECT_TRUE(actuator.is_at_full_force());
  actuator.vent();
  EXPECT_FALSE(actuator.is_at_full_force());
}

TEST(GripperActuator, GoesOnFromASavedState) {
  auto slow = gripper(scene::GripperDrive::kPneumatic);
  slow.fill_time_s = 0.05;
  GripperActuator actuator(slow), other(slow);
  EXPECT_TRUE(actuator.command(0));
  EXPECT_TRUE(actuator.set_force(20));
  for (int i = 0; i < 40; ++i) (void)actuator.advance(kMiddle, kClosed, kStep);
  other.restore(actuator.save());
  const auto expected = actuator.advance(kMiddle, kClosed, kStep);
  const auto drives = other.advance(kMiddle, kClosed, kStep);
  EXPECT_GT(expected[0].piston_n, 0);
  EXPECT_EQ(drives[0].piston_n, expected[0].piston_n);
  EXPECT_EQ(drives[0].speed_m_s, expected[0].speed_m_s);
  EXPECT_EQ(other.force_n(), 20);
}

}  // namespace
}  // namespace aprsim::physics
