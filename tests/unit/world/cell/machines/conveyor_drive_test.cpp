#include "world/cell/machines/conveyor_drive.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace aprsim::world {
namespace {

constexpr double kDriveStep = 1e-3;
constexpr ConveyorDriveLimits kLimits{
    .max_speed_m_s = 0.3, .accel_m_s2 = 0.5, .decel_m_s2 = 0.4, .emergency_decel_m_s2 = 2.0};

void run_for(ConveyorDrive& drive, int steps) {
  for (int i = 0; i < steps; ++i) drive.step(kDriveStep);
}

/// Runs at a speed, forward, with the ramp behind it.
ConveyorDrive running(double speed_m_s) {
  ConveyorDrive drive(kLimits);
  drive.apply({.run = true, .forward = true, .speed_m_s = speed_m_s});
  run_for(drive, 1000);
  EXPECT_EQ(drive.state().speed_m_s, speed_m_s);
  return drive;
}

/// Steps until the belt stands; at most 10 s.
int steps_to_stand(ConveyorDrive& drive) {
  int steps = 0;
  while (drive.state().speed_m_s != 0 && steps < 10000) {
    drive.step(kDriveStep);
    ++steps;
  }
  return steps;
}

TEST(ConveyorDrive, RampsWithinItsAccelerationToTheSetSpeed) {
  ConveyorDrive drive(kLimits);
  drive.apply({.run = true, .forward = true, .speed_m_s = 0.15});
  double before = 0;
  for (int i = 0; i < 1000; ++i) {
    const double now = drive.step(kDriveStep);
    EXPECT_LE(std::abs(now - before), 0.5 * kDriveStep + 1e-15);
    before = now;
  }
  EXPECT_EQ(before, 0.15);
  // Area under the ramp: 0.3 s to speed, then 0.7 s at speed.
  EXPECT_NEAR(drive.state().travel_m, 0.5 * 0.3 * 0.15 + 0.7 * 0.15, 1e-9);
}

TEST(ConveyorDrive, ReversalGoesThroughZero) {
  ConveyorDrive drive(kLimits);
  drive.apply({.run = true, .forward = true, .speed_m_s = 0.1});
  for (int i = 0; i < 500; ++i) drive.step(kDriveStep);
  drive.apply({.run = {}, .forward = false, .speed_m_s = {}});
  bool stood = false;
  for (int i = 0; i < 500; ++i) stood = std::abs(drive.step(kDriveStep)) < 5e-4 || stood;
  EXPECT_TRUE(stood);
  EXPECT_EQ(drive.state().speed_m_s, -0.1);
}

TEST(ConveyorDrive, SpeedAloneDoesNotMoveAndStopKeepsTheSetting) {
  ConveyorDrive drive(kLimits);
  drive.apply({.run = {}, .forward = {}, .speed_m_s = 0.2});
  EXPECT_EQ(drive.step(kDriveStep), 0);
  drive.apply({.run = true, .forward = {}, .speed_m_s = {}});
  for (int i = 0; i < 1000; ++i) drive.step(kDriveStep);
  EXPECT_EQ(drive.state().speed_m_s, 0.2);
  drive.apply({.run = false, .forward = {}, .speed_m_s = {}});
  for (int i = 0; i < 1000; ++i) drive.step(kDriveStep);
  EXPECT_EQ(drive.state().speed_m_s, 0);
  EXPECT_EQ(drive.state().speed_setting_m_s, 0.2);
}

TEST(ConveyorDrive, TheMotorSaturates) {
  ConveyorDrive drive(kLimits);
  drive.apply({.run = true, .forward = true, .speed_m_s = 0.32768});
  for (int i = 0; i < 2000; ++i) drive.step(kDriveStep);
  EXPECT_EQ(drive.state().speed_m_s, 0.3);
  EXPECT_EQ(drive.state().speed_setting_m_s, 0.32768);
}

TEST(ConveyorDrive, EachRampHasItsOwnSlope) {
  ConveyorDrive drive = running(0.2);
  drive.apply({.run = false});
  EXPECT_EQ(steps_to_stand(drive), 500) << "0.2 m/s at 0.4 m/s^2";
  drive = running(0.2);
  drive.apply({.speed_m_s = 0.1});
  run_for(drive, 200);
  EXPECT_NEAR(drive.state().speed_m_s, 0.12, 1e-12) << "slowing down brakes";
  drive = running(0.2);
  drive.apply({.emergency_stop = true});
  EXPECT_EQ(steps_to_stand(drive), 100) << "0.2 m/s at 2 m/s^2";
}

TEST(ConveyorDrive, ReversalBrakesToZeroAndThenAccelerates) {
  ConveyorDrive drive = running(0.2);
  drive.apply({.forward = false});
  EXPECT_EQ(steps_to_stand(drive), 500);
  drive.step(kDriveStep);
  EXPECT_NEAR(drive.state().speed_m_s, -0.5 * kDriveStep, 1e-15);
}

TEST(ConveyorDrive, AnEmergencyStopIsHeldUntilReleasedAndReset) {
  ConveyorDrive drive = running(0.2);
  drive.apply({.emergency_stop = true});
  EXPECT_TRUE(drive.state().emergency_stop);
  EXPECT_EQ(drive.state().fault, api::DriveFault::kEmergencyStop);
  EXPECT_FALSE(drive.state().run);
  drive.apply({.run = true});
  EXPECT_FALSE(drive.state().run);
  drive.apply({.fault_reset = true});
  EXPECT_EQ(drive.state().fault, api::DriveFault::kEmergencyStop) << "still engaged";
  drive.apply({.emergency_stop = false});
  EXPECT_EQ(drive.state().fault, api::DriveFault::kEmergencyStop) << "released, not reset";
  drive.apply({.run = true});
  EXPECT_FALSE(drive.state().run);
  run_for(drive, 1000);
  EXPECT_EQ(drive.state().speed_m_s, 0);
  drive.apply({.fault_reset = true});
  EXPECT_EQ(drive.state().fault, api::DriveFault::kNone);
  run_for(drive, 100);
  EXPECT_EQ(drive.state().speed_m_s, 0) << "does not start by itself";
  drive.apply({.run = true});
  run_for(drive, 1000);
  EXPECT_EQ(drive.state().speed_m_s, 0.2) << "the setting has stayed";
}

TEST(ConveyorDrive, ReleaseResetAndRunMayComeTogetherAndTheStopWins) {
  ConveyorDrive drive(kLimits);
  drive.apply({.emergency_stop = true});
  drive.apply({.run = true, .emergency_stop = false, .fault_reset = true});
  EXPECT_TRUE(drive.state().run);
  drive.apply({.run = true, .emergency_stop = true, .fault_reset = true});
  EXPECT_FALSE(drive.state().run);
  EXPECT_EQ(drive.state().fault, api::DriveFault::kEmergencyStop);
}

TEST(ConveyorDrive, TheWatchdogStopsARunningBeltThatNobodyTalksTo) {
  ConveyorDrive drive(kLimits);
  drive.apply({.run = true, .speed_m_s = 0.2, .watchdog_s = 0.5});
  for (int i = 0; i < 4; ++i) {
    run_for(drive, 490);
    drive.apply({});  // nothing set, and yet a sign of life
  }
  EXPECT_EQ(drive.state().fault, api::DriveFault::kNone);
  run_for(drive, 499);
  EXPECT_TRUE(drive.state().run);
  run_for(drive, 2);
  EXPECT_EQ(drive.state().fault, api::DriveFault::kWatchdog);
  EXPECT_FALSE(drive.state().run);
  EXPECT_NEAR(steps_to_stand(drive), 500, 2) << "an ordinary ramp";
  drive.apply({.run = true});
  EXPECT_FALSE(drive.state().run);
  drive.apply({.fault_reset = true});
  drive.apply({.run = true});
  EXPECT_TRUE(drive.state().run);
}

TEST(ConveyorDrive, TheWatchdogLeavesAStandingBeltAloneAndCanBeTurnedOff) {
  ConveyorDrive drive(kLimits);
  drive.apply({.watchdog_s = 0.1});
  run_for(drive, 1000);
  EXPECT_EQ(drive.state().fault, api::DriveFault::kNone);
  drive.apply({.run = true, .speed_m_s = 0.1, .watchdog_s = 0.0});
  run_for(drive, 1000);
  EXPECT_EQ(drive.state().fault, api::DriveFault::kNone);
}

TEST(ConveyorDrive, MotorCurrentFollowsItsModel) {
  ConveyorDrive drive(kLimits);
  drive.set_load(2.0);
  EXPECT_EQ(drive.state().motor_current_a, 0);
  drive.apply({.run = true, .forward = false, .speed_m_s = 0.2});
  drive.step(kDriveStep);
  EXPECT_NEAR(drive.state().motor_current_a, 5.0 * (0.5 + 0.3 * 9.81) / 40, 1e-9) << "accelerating";
  run_for(drive, 1000);
  EXPECT_NEAR(drive.state().motor_current_a, 5.0 * 0.3 * 9.81 / 40, 1e-9) << "at speed";
  drive.apply({.emergency_stop = true});
  drive.step(kDriveStep);
  EXPECT_NEAR(drive.state().motor_current_a, 5.0 * (0.3 * 9.81 - 2.0) / 40, 1e-9) << "braking";
}

TEST(ConveyorDrive, TheLightCurtainStopsItByTheEmergencyRampAndHolds) {
  ConveyorDrive drive = running(0.2);
  drive.set_light_curtain(true);
  EXPECT_EQ(drive.state().fault, api::DriveFault::kLightCurtain);
  EXPECT_EQ(steps_to_stand(drive), 100) << "0.2 m/s at 2 m/s^2";
  drive.apply({.run = true, .fault_reset = true});
  EXPECT_EQ(drive.state().fault, api::DriveFault::kLightCurtain) << "still broken";
  EXPECT_FALSE(drive.state().run);
  drive.set_light_curtain(false);
  EXPECT_EQ(drive.state().fault, api::DriveFault::kLightCurtain) << "clear, not reset";
  drive.apply({.run = true});
  EXPECT_FALSE(drive.state().run);
  drive.apply({.run = true, .fault_reset = true});
  EXPECT_EQ(drive.state().fault, api::DriveFault::kNone);
  EXPECT_TRUE(drive.state().run);
}

TEST(ConveyorDrive, StaysFaultedUntilBothFaultsEnd) {
  ConveyorDrive drive = running(0.2);
  drive.set_light_curtain(true);
  drive.apply({.emergency_stop = true});
  EXPECT_EQ(drive.state().fault, api::DriveFault::kEmergencyStop);
  drive.apply({.emergency_stop = false, .fault_reset = true});
  EXPECT_EQ(drive.state().fault, api::DriveFault::kLightCurtain) << "the other cause persists";
  drive.apply({.emergency_stop = true});
  drive.set_light_curtain(false);
  EXPECT_EQ(drive.state().fault, api::DriveFault::kEmergencyStop);
  drive.apply({.emergency_stop = false, .fault_reset = true});
  EXPECT_EQ(drive.state().fault, api::DriveFault::kNone);
}

}  // namespace
}  // namespace aprsim::world
