#include "world/cell/cell_readings.hpp"

#include <algorithm>
#include <array>
#include <optional>

#include <gtest/gtest.h>

#include "tests/unit/world/cell/bare_cell.hpp"
#include "tests/unit/world/faults/fault_cell.hpp"

namespace aprsim::test {
namespace {

using faults::Quantity;

double value_of(const world::World& world, Quantity quantity, int robot = -1, int joint = 1) {
  return world::CellReadings(world.settings(), world.robots(), world.physics(), world.conveyor(),
                             nullptr)
      .quantity(quantity, robot, joint - 1);
}

TEST(CellReadings, AreThoseOfTheSnapshotBitForBit) {
  FaultCell cell;
  cell.grasp("part_large_gear_1");
  cell.run_belt(0.1);
  cell.tell(kFanucArm, turn(0, 0.3));
  cell.advance(200);
  const api::RobotSnapshot& fanuc = cell.robot(kFanucArm);
  ASSERT_TRUE(fanuc.gripper.holding);
  ASSERT_GT(fanuc.force_T_R.norm(), 0);
  ASSERT_GT(cell.now.conveyor.travel_m, 0);
  const auto value = [&](Quantity quantity, int joint = 1) {
    return value_of(cell.world, quantity, kFanucArm, joint);
  };
  for (int joint = 1; joint <= 6; ++joint) {
    EXPECT_EQ(value(Quantity::kJointPosition, joint),
              fanuc.joints[static_cast<std::size_t>(joint - 1)].position_rad);
  }
  EXPECT_EQ(value(Quantity::kToolHeight), fanuc.X_WT.p.z());
  EXPECT_EQ(value(Quantity::kToolForce), fanuc.force_T_R.norm());
  EXPECT_EQ(value(Quantity::kGripForce),
            std::min(fanuc.gripper.force_n[0], fanuc.gripper.force_n[1]));
  EXPECT_EQ(value(Quantity::kSeparation), fanuc.gripper.separation_m);
  EXPECT_EQ(value_of(cell.world, Quantity::kBeltTravel), cell.now.conveyor.travel_m);
  EXPECT_EQ(value_of(cell.world, Quantity::kBeltSpeed), cell.now.conveyor.speed_m_s);
}

TEST(CellReadings, KnowGripsTypesAndBeams) {
  BareCell cell;
  const world::CellReadings readings = cell.readings();
  EXPECT_EQ(readings.robots(), 2);
  EXPECT_EQ(readings.grip(0).held_body, -1);
  EXPECT_EQ(readings.type_of(cell.body("part_large_gear_1")), "sku_part_large_gear");
  EXPECT_FALSE(readings.beam_broken(0));
  const world::CellReadings without_belt(cell.settings, cell.robots, *cell.physics, nullptr,
                                         nullptr);
  EXPECT_FALSE(without_belt.beam_broken(0));
}

TEST(CellReadings, MeasureTheWayToTheEndOfTheBeltAhead) {
  BareCell cell;
  const int tray = cell.body("large_gear_vessel_1");
  const scene::Conveyor& belt = *cell.settings.conveyor;
  const Eigen::Isometry3d X_WP = belt.X_WC.isometry() * Eigen::Translation3d(0.2, 0, 0.02);
  const std::array<physics::PhysicsWorld::Placement, 1> place{{{tray, X_WP}}};
  cell.physics->place(place);
  EXPECT_EQ(cell.readings().distance_to_belt_end(tray), std::nullopt) << "the belt is at rest";
  const auto run = [&](bool forward) {
    cell.conveyor.apply({.run = true,
                         .forward = forward,
                         .speed_m_s = 0.1,
                         .emergency_stop = {},
                         .watchdog_s = {}});
    for (int i = 0; i < 2000; ++i) cell.conveyor.step(1e-3);
    return cell.readings().distance_to_belt_end(tray);
  };
  const auto ahead = run(true), back = run(false);
  ASSERT_TRUE(ahead && back);
  EXPECT_NEAR(*ahead, 0.5 * belt.length_m - 0.2, 1e-9);
  EXPECT_NEAR(*back, 0.5 * belt.length_m + 0.2, 1e-9);
  EXPECT_EQ(cell.readings().distance_to_belt_end(cell.body("part_large_gear_1")), std::nullopt)
      << "not on the belt";
}

}  // namespace
}  // namespace aprsim::test
