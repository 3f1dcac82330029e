#include <limits>

#include <gtest/gtest.h>

#include "tests/unit/world/physics/cell_builder.hpp"

namespace aprsim::physics::test {
namespace {

TEST(Divergence, OfABodyIsTheLossOfThatBody) {
  auto scene = empty_scene();
  add_table(scene);
  add_tray(scene, "tray", "small4", {0, 0}, {"s1=g1", "s2=g2"});
  scene.gears[0].X_WP.p.x() = std::numeric_limits<double>::quiet_NaN();
  Bench bench(std::move(scene));
  bench.run(200);
  EXPECT_TRUE(bench.world->lost(bench.index_of("g1")));
  EXPECT_FALSE(bench.world->lost(bench.index_of("g2")));
  EXPECT_FALSE(bench.world->lost(bench.index_of("tray")));
  EXPECT_NEAR(bench.X_WB("tray").translation().z(), 0.015, 20e-6);
}

TEST(Divergence, RunawaySpeedIsTheLossOfThatBody) {
  auto scene = empty_scene();
  add_table(scene);
  add_tray(scene, "tray", "small4", {0, 0}, {"s1=g1"});
  Pose high;
  high.p.z() = 1;
  add_gear(scene, "meteor", "small", high);
  Bench bench(std::move(scene));
  bench.world->set_velocity(bench.index_of("meteor"), {0, 0, 2000}, {0, 0, 0});
  bench.run(10);
  EXPECT_TRUE(bench.world->lost(bench.index_of("meteor")));
  EXPECT_FALSE(bench.world->lost(bench.index_of("g1")));
}

/// Rods that roll and tumble fast, and impacts at 30 m/s, are sound.
TEST(Divergence, FastSoundPartsAreKept) {
  auto scene = empty_scene();
  add_table(scene);
  Pose high;
  high.p.z() = 0.5;
  add_gear(scene, "g", "small", high);
  Bench bench(std::move(scene));
  bench.world->set_velocity(0, {0, 0, -30}, {1500, 1500, 0});
  bench.run(10);
  EXPECT_FALSE(bench.world->lost(0));
}

// Started 2 mm deep in the table: counted, reported, pushed out without an explosion.
TEST(Divergence, PenetrationIsCounted) {
  auto scene = empty_scene();
  add_table(scene);
  add_tray(scene, "tray", "small4", {0, 0}, {});
  scene.trays[0].X_WP.p.z() -= 2e-3;
  Bench bench(std::move(scene));
  bench.run(1);
  EXPECT_NEAR(bench.world->max_penetration_m(), 2e-3, 0.1e-3);
  EXPECT_GT(bench.world->penetration_faults(), 0u);
  bench.run(500);
  EXPECT_NEAR(bench.X_WB("tray").translation().z(), 0.015, 20e-6);
}

}  // namespace
}  // namespace aprsim::physics::test
