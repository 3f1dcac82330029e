// The example of clients/devices.

#include <cmath>

#include <gtest/gtest.h>

#include "tests/unit/world/devices/device_scene.hpp"

namespace aprsim::test {
namespace {

constexpr double kEmptyTray_kg = 0.2;
const std::string kOnTheScale =
    "trays:\n  - {name: small_gear_vessel_1, type: sku_small_gear_vessel, on: conveyor, "
    "xy_m: [0, 0]}\n";

TEST(Scale, ReadingFollowsTheLoadWithItsLag) {
  world::World world(scene_with(scale(", settling_s: 0.05") + kOnTheScale), 1);
  for (int step = 1; step <= 600; ++step) {
    world.step();
    if (step % 20 != 0) continue;
    const double expected = kEmptyTray_kg * (1 - std::exp(-1e-3 * step / 0.05));
    EXPECT_NEAR(signal(snapshot_of(world), "scale", "mass_kg"), expected, 1e-12) << step;
  }
  EXPECT_EQ(signal(snapshot_of(world), "scale", "full"), 0);
}

TEST(Scale, StopsTheBeltWhichGoesOnByACommand) {
  world::World world(scene_with(scale(", settling_s: 0.01, full_kg: 0.19")), 1);
  world.apply(0, api::ConveyorCommand{.run = true, .forward = true, .speed_m_s = 0.3});
  int steps = 0;
  while (signal(snapshot_of(world), "scale", "full") == 0 && ++steps < 6000) world.step();
  ASSERT_LT(steps, 6000);
  EXPECT_FALSE(world.conveyor()->state().run);
  advance(world, 1000);
  const api::Snapshot now = snapshot_of(world);
  EXPECT_EQ(now.conveyor.speed_m_s, 0);
  // It stands within the box: the way of braking is short.
  EXPECT_NEAR(now.bodies[0].X_WB.p.x(), -0.3, 0.12);
  world.apply(0, api::ConveyorCommand{.run = true});
  advance(world, 500);
  EXPECT_TRUE(world.conveyor()->state().run);
}

}  // namespace
}  // namespace aprsim::test
