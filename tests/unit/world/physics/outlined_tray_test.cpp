#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/support/parameter_names.hpp"
#include "tests/unit/world/physics/cell_builder.hpp"

// Trays with an outline in the whole physics: they rest, slide, are gripped, and nothing passes.
namespace aprsim::physics::test {
namespace {

using Eigen::Vector3d;

/// The wedge of the kit m2l1, with fewer corners.
scene::TrayType wedge_type() {
  scene::TrayType type;
  type.name = "wedge";
  type.kind = api::BodyKind::kKitTray;
  type.outline = scene::outline_of({{-0.0968, -0.0632},
                                    {-0.0092, -0.1282},
                                    {0.009, -0.1282},
                                    {0.0966, -0.0632},
                                    {0.108, -0.0404},
                                    {0.108, 0.0138},
                                    {0.0884, 0.041},
                                    {-0.0886, 0.041},
                                    {-0.1076, 0.0184},
                                    {-0.1082, -0.0404}});
  type.min_xy = {-0.1082, -0.1282};
  type.max_xy = {0.108, 0.041};
  type.thickness_m = 0.015;
  type.mass_kg = 0.2;
  return type;
}

scene::Scene wedge_scene(scene::Simplification mode, double yaw_rad) {
  auto scene = empty_scene();
  scene.physics.simplification = mode;
  scene.tray_types["wedge"] = wedge_type();
  add_table(scene);
  add_tray(scene, "wedge", "wedge", {0, 0}, {}, yaw_rad);
  return scene;
}

class OutlinedTray : public testing::TestWithParam<scene::Simplification> {};

// As in Rest: two surface layers of 10 um, no drift beyond the solver's tolerance.
TEST_P(OutlinedTray, RestsWithoutDrift) {
  for (const double yaw : {0.0, 0.7, 2.9}) {
    auto scene = wedge_scene(GetParam(), yaw);
    scene.trays[0].X_WP.p.z() += 1e-3;
    Bench bench(std::move(scene));
    bench.run(500);
    const Eigen::Isometry3d settled = bench.X_WB("wedge");
    EXPECT_NEAR(settled.translation().z(), 0.015, 12e-6) << yaw;
    EXPECT_TRUE(bench.world->body(0).resting) << yaw;
    bench.run(2000);
    EXPECT_LT((bench.X_WB("wedge").translation() - settled.translation()).norm(), 1.5e-7) << yaw;
    EXPECT_LT(angle_between(bench.X_WB("wedge"), settled), 1e-6) << yaw;
    EXPECT_EQ(bench.world->penetration_faults(), 0u);
  }
}

// Coulomb: friction decelerates a sliding body by mu g however it lies, and without turning it.
TEST_P(OutlinedTray, SlidesAsFarAsFrictionLetsIt) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> angle(-3, 3), speed(0.3, 1.0);
  for (int i = 0; i < 6; ++i) {
    const double v = speed(random), heading = angle(random), mu = 0.4;
    auto scene = wedge_scene(GetParam(), angle(random));
    scene.physics.friction.tray_ground = mu;
    Bench bench(std::move(scene));
    bench.run(200);
    const Eigen::Isometry3d begin = bench.X_WB("wedge");
    bench.world->set_velocity(0, v * Vector3d(std::cos(heading), std::sin(heading), 0),
                              Vector3d::Zero());
    bench.run(800);
    const Eigen::Isometry3d end = bench.X_WB("wedge");
    const Vector3d way = end.translation() - begin.translation();
    // Velocities at the ends of the steps count (semi-implicit Euler).
    const double far =
        v * v / (2 * mu * bench.scene.physics.gravity_m_s2) - 0.5 * v * bench.scene.physics.step_s;
    EXPECT_NEAR(way.dot(Vector3d(std::cos(heading), std::sin(heading), 0)), far, 1e-3 * far) << i;
    EXPECT_LT(std::abs(way.dot(Vector3d(-std::sin(heading), std::cos(heading), 0))), 1e-3 * far)
        << i;
    EXPECT_LT(angle_between(end, begin), 1e-3) << i;
    EXPECT_LT(bench.world->body(0).v_W.norm(), 1e-8) << i;
  }
}

/// A bar with pointed ends, narrow enough for the fingers.
TEST_P(OutlinedTray, IsGrippedAndLifted) {
  auto scene = empty_scene();
  scene.physics.simplification = GetParam();
  add_table(scene);
  scene::TrayType bar;
  bar.name = "bar";
  bar.kind = api::BodyKind::kKitTray;
  bar.outline = scene::outline_of(
      {{-0.03, -0.006}, {0.04, -0.006}, {0.05, 0}, {0.04, 0.006}, {-0.03, 0.006}, {-0.05, 0}});
  bar.min_xy = {-0.05, -0.006};
  bar.max_xy = {0.05, 0.006};
  bar.thickness_m = 0.02;
  bar.mass_kg = 0.15;
  scene.tray_types["bar"] = bar;
  add_tray(scene, "bar", "bar", {0, 0}, {});
  constexpr double kUp = 0.05;
  add_hand(scene, {0, 0, 0.006 + kUp});
  Bench bench(std::move(scene));
  bench.run(120);
  bench.move({0, 0, -kUp}, 0.15);
  bench.grip(0);
  EXPECT_TRUE(bench.world->gripper(0).holding);
  bench.move({0, 0, kUp}, 0.3);
  bench.run(100);
  EXPECT_GT(bench.X_WB("bar").translation().z(), 0.05);
  const Eigen::Isometry3d held = bench.X_TB("bar");
  bench.run(1000);
  EXPECT_LT((bench.X_TB("bar").translation() - held.translation()).norm(), 1e-5);
  bench.grip(1);
  bench.run(500);
  EXPECT_FALSE(bench.world->gripper(0).holding);
  EXPECT_NEAR(bench.X_WB("bar").translation().z(), 0.02, 12e-6);
}

INSTANTIATE_TEST_SUITE_P(Modes, OutlinedTray,
                         testing::Values(scene::Simplification::kOff,
                                         scene::Simplification::kVirtualJoints,
                                         scene::Simplification::kMerge,
                                         scene::Simplification::kDormant));

// A gear at 10 m/s, at the side and the top of a wedge that the table's friction hardly holds, and
// wedges at a plate 5 mm thick.
TEST(OutlinedTrayImpact, NothingPasses) {
  const scene::TrayType type = wedge_type();
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> share(-1, 1);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 60; ++i) {
    auto scene = empty_scene();
    scene.tray_types["wedge"] = type;
    Pose plate;
    plate.p.z() = -0.0025;
    scene.fixed.push_back({"plate", {20, 20, 0.005}, plate});
    Pose above;
    above.p = {0, 0, 0.3};
    const double w = normal(random), x = normal(random), y = normal(random);
    above.q = Eigen::Quaterniond(w, x, y, normal(random)).normalized();
    scene.trays.push_back({.name = "wedge", .type = "wedge", .X_WP = above});
    add_tray(scene, "lying", "wedge", {1, 0}, {}, 3 * share(random));
    Pose gear;
    gear.p = {1 + 0.05 * share(random), 0.05 * share(random), 0.3};
    gear.q = above.q;
    add_gear(scene, "gear", "medium", gear);
    Bench bench(std::move(scene));
    const double speed = 5 + 5 * std::abs(share(random));
    bench.world->set_velocity(bench.index_of("wedge"), {0.3 * speed * share(random), 0, -speed},
                              5 * Vector3d(share(random), share(random), share(random)));
    bench.world->set_velocity(bench.index_of("gear"), {0, 0, -speed},
                              5 * Vector3d(share(random), share(random), share(random)));
    for (int step = 0; step < 300; ++step) {
      bench.run(1);
      const Eigen::Isometry3d X_WP = bench.X_WB("wedge");
      double lowest = 1;
      for (const auto& corner : type.outline->corners) {
        for (const double z : {-0.015, 0.0}) {
          lowest = std::min(lowest, (X_WP * Vector3d(corner.x(), corner.y(), z)).z());
        }
      }
      ASSERT_GT(lowest, -0.5e-3) << i << " at " << step;
    }
    EXPECT_GT(bench.X_WB("gear").translation().z(), -0.5e-3) << i;
    EXPECT_EQ(bench.world->penetration_faults(), 0u) << i;
  }
}

}  // namespace
}  // namespace aprsim::physics::test
