#include "world/conveyor_drive.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace aprsim::world {
namespace {

constexpr double kStep = 1e-3;

TEST(ConveyorDrive, RampsWithinItsAccelerationToTheSetSpeed) {
  ConveyorDrive drive(0.3, 0.5);
  drive.take({.run = true, .forward = true, .speed_m_s = 0.15});
  double before = 0;
  for (int i = 0; i < 1000; ++i) {
    const double now = drive.step(kStep);
    EXPECT_LE(std::abs(now - before), 0.5 * kStep + 1e-15);
    before = now;
  }
  EXPECT_EQ(before, 0.15);
  // Area under the ramp: 0.3 s to speed, then 0.7 s at speed.
  EXPECT_NEAR(drive.state().travel_m, 0.5 * 0.3 * 0.15 + 0.7 * 0.15, 1e-9);
}

TEST(ConveyorDrive, ReversalGoesThroughZero) {
  ConveyorDrive drive(0.3, 0.5);
  drive.take({.run = true, .forward = true, .speed_m_s = 0.1});
  for (int i = 0; i < 500; ++i) drive.step(kStep);
  drive.take({.run = {}, .forward = false, .speed_m_s = {}});
  bool stood = false;
  for (int i = 0; i < 500; ++i) stood = std::abs(drive.step(kStep)) < 5e-4 || stood;
  EXPECT_TRUE(stood);
  EXPECT_EQ(drive.state().speed_m_s, -0.1);
}

TEST(ConveyorDrive, SpeedAloneDoesNotMoveAndStopKeepsTheSetting) {
  ConveyorDrive drive(0.3, 0.5);
  drive.take({.run = {}, .forward = {}, .speed_m_s = 0.2});
  EXPECT_EQ(drive.step(kStep), 0);
  drive.take({.run = true, .forward = {}, .speed_m_s = {}});
  for (int i = 0; i < 1000; ++i) drive.step(kStep);
  EXPECT_EQ(drive.state().speed_m_s, 0.2);
  drive.take({.run = false, .forward = {}, .speed_m_s = {}});
  for (int i = 0; i < 1000; ++i) drive.step(kStep);
  EXPECT_EQ(drive.state().speed_m_s, 0);
  EXPECT_EQ(drive.state().speed_setting_m_s, 0.2);
}

TEST(ConveyorDrive, TheMotorSaturates) {
  ConveyorDrive drive(0.3, 0.5);
  drive.take({.run = true, .forward = true, .speed_m_s = 0.32768});
  for (int i = 0; i < 2000; ++i) drive.step(kStep);
  EXPECT_EQ(drive.state().speed_m_s, 0.3);
  EXPECT_EQ(drive.state().speed_setting_m_s, 0.32768);
}

}  // namespace
}  // namespace aprsim::world
