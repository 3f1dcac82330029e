// Commands of devices, against closed forms and against the same commands of clients.

#include <random>

#include <gtest/gtest.h>

#include "tests/unit/world/devices/device_scene.hpp"

namespace aprsim::test {
namespace {

constexpr double kTray_kg = 0.2, kGravity = 9.81, kBeltFriction = 0.8;
const std::string kTray = "body: small_gear_vessel_1";

std::string number(double value) { return std::to_string(value); }

/// A tray on the belt that is pushed along x by `force_n` for 100 steps; its velocity then.
double pushed(double force_n) {
  const std::string push = mover("push", "action: push, " + kTray + ", amount: " + number(force_n) +
                                             ", at_step: 200, until_step: 300");
  world::World world(scene_with(push), 1);
  advance(world, 300);
  return snapshot_of(world).bodies[0].v_W.x();
}

TEST(DeviceActions, AForceOvercomesFrictionAsCoulombSays) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> force(0.2, 4);
  for (int i = 0; i < 12; ++i) {
    const double force_n = force(random);
    const double held_n = kBeltFriction * kTray_kg * kGravity;
    const double expected = force_n < held_n ? 0 : 0.1 * (force_n - held_n) / kTray_kg;
    EXPECT_NEAR(pushed(force_n), expected, 0.01 * expected + 1e-6) << force_n;
  }
}

TEST(DeviceActions, ATorqueTurnsABodyThatFalls) {
  // In the air, so that nothing else acts: omega_z = t * torque / I_z of the slab.
  const std::string parts =
      "parts:\n  - {name: cube, type: cube, xyz_m: [0, 2, 5]}\n"
      "part_types:\n  cube: {density_kg_m3: 1000, pieces: [{box: {size_m: [0.1, 0.1, 0.1]}}]}\n";
  const std::string turn =
      mover("turn", "action: turn, body: cube, amount: 0.02, at_step: 10, until_step: 60");
  world::World world(scene_with(turn + parts), 1);
  advance(world, 60);
  const api::Snapshot now = snapshot_of(world);
  const double inertia = 1.0 * (0.01 + 0.01) / 12;
  EXPECT_NEAR(now.bodies.back().omega_W.z(), 0.05 * 0.02 / inertia, 1e-9);
  EXPECT_NEAR(now.bodies.back().omega_W.head<2>().norm(), 0, 1e-9);
  EXPECT_NEAR(now.bodies.back().v_W.z(), -kGravity * 0.06, 1e-6);
}

TEST(DeviceActions, TheBeltRunsAsByACommand) {
  const std::string run = mover("run", "action: run_belt, amount: -0.2, at_step: 100, once: true");
  world::World by_device(scene_with(run), 1), by_client(scene_with(""), 1);
  advance(by_device, 100);
  advance(by_client, 100);
  by_client.apply(0, api::ConveyorCommand{.run = true, .forward = false, .speed_m_s = 0.2});
  for (int i = 0; i < 20; ++i) {
    advance(by_device, 50);
    advance(by_client, 50);
    EXPECT_EQ(by_device.physics().state_hash(), by_client.physics().state_hash()) << i;
  }
  EXPECT_NEAR(by_device.conveyor()->state().speed_m_s, -0.2, 1e-12);
}

TEST(DeviceActions, PlacedAndRemovedBodies) {
  const std::string two =
      mover("place", "action: place, " + kTray + ", amount: 0.25, at_step: 50, once: true") +
      mover("remove", "action: remove, " + kTray + ", at_step: 500, once: true");
  world::World world(scene_with(two), 1);
  const double x = snapshot_of(world).bodies[0].X_WB.p.x();
  advance(world, 400);
  EXPECT_NEAR(snapshot_of(world).bodies[0].X_WB.p.x(), x + 0.25, 1e-4);
  advance(world, 200);
  EXPECT_TRUE(snapshot_of(world).bodies[0].lost_step.has_value());
  // A removed body is not acted on.
  advance(world, 100);
  EXPECT_EQ(fault(snapshot_of(world), "remove"), "");
}

TEST(DeviceActions, GripperAndProtectiveStop) {
  const std::string two =
      mover("grip", "action: gripper, robot: fanuc, amount: 0, at_step: 20, once: true") +
      mover("stop", "action: stop_robot, robot: fanuc, at_step: 900, once: true");
  world::World world(scene_with(two, "fanuc_only"), 1);
  const double open_m = snapshot_of(world).robots[0].gripper.separation_m;
  advance(world, 800);
  const api::Snapshot closed = snapshot_of(world);
  EXPECT_LT(closed.robots[0].gripper.separation_m, open_m - 0.005);
  EXPECT_FALSE(closed.robots[0].protective_stop);
  advance(world, 200);
  EXPECT_TRUE(snapshot_of(world).robots[0].protective_stop);
}

}  // namespace
}  // namespace aprsim::test
