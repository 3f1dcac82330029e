// When friction lets go, and by how much: against closed forms, in every mode.

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/support/parameter_names.hpp"
#include "tests/unit/world/physics/cell_builder.hpp"

namespace aprsim::physics::test {
namespace {

using scene::Simplification;

constexpr double kTime = 0.1;  // [s] of acceleration

/// A flat plate on a belt that turns what the belt does into acceleration: nothing slips under it.
scene::Scene plate_scene(Simplification mode) {
  auto scene = empty_scene();
  scene.physics.simplification = mode;
  scene.physics.friction.tray_belt = 3;
  scene.physics.friction.gear_tray = 0.3;
  scene::TrayType plate;
  plate.name = "plate";
  plate.min_xy = {-0.2, -0.2};
  plate.max_xy = {0.2, 0.2};
  plate.thickness_m = 0.01;
  plate.mass_kg = 1;
  scene.tray_types["plate"] = plate;
  add_belt(scene, 6);
  add_tray(scene, "plate", "plate", {0, 0}, {});
  return scene;
}

/// A gear stands on its hub.
void stand_gear(scene::Scene& scene, const std::string& name, double x, double y, double z) {
  Pose pose;
  pose.p = {x, y, z};
  add_gear(scene, name, "large", pose);
}

/// Runs the belt at `accel` for kTime; the slip of `body` on the plate.
double slip(Bench& bench, const std::string& body, double accel) {
  const auto place = [&]() -> Eigen::Vector3d {
    return (bench.X_WB("plate").inverse() * bench.X_WB(body)).translation();
  };
  const Eigen::Vector3d before = place();
  const int steps = static_cast<int>(std::lround(kTime / bench.scene.physics.step_s));
  for (int i = 1; i <= steps; ++i) {
    bench.world->set_belt_speed(accel * bench.scene.physics.step_s * i);
    bench.run(1);
  }
  return (place() - before).norm();
}

/// Distance that a body slides from rest in n steps of size h: velocities are integrated first.
double closed_form(double accel, double mu_g, double h) {
  const double n = std::round(kTime / h);
  return accel <= mu_g ? 0 : 0.5 * (accel - mu_g) * h * h * n * (n + 1);
}

class BreakUp : public testing::TestWithParam<Simplification> {};

TEST_P(BreakUp, GearOnAnAcceleratingPlate) {
  const double mu_g = 0.3 * 9.81;
  for (const double accel : {2.0, 2.9, 2.94, 2.96, 3.0, 5.0, 8.0}) {
    auto scene = plate_scene(GetParam());
    stand_gear(scene, "gear", 0, 0, 0.022);
    Bench bench(std::move(scene));
    bench.run(200);
    EXPECT_NEAR(slip(bench, "gear", accel), closed_form(accel, mu_g, 1e-3), 1e-6) << accel;
  }
}

// Nothing depends on how the plate lies and where the belt goes.
TEST_P(BreakUp, GearOnATurnedPlate) {
  const double mu_g = 0.3 * 9.81;
  for (const double accel : {2.9, 3.0, 5.0}) {
    auto scene = plate_scene(GetParam());
    stand_gear(scene, "gear", 0, 0, 0.022);
    scene.trays[0].X_WP.q = Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ());
    scene.conveyor->X_WC.q = Eigen::AngleAxisd(0.6, Eigen::Vector3d::UnitZ());
    Bench bench(std::move(scene));
    bench.run(200);
    EXPECT_NEAR(slip(bench, "gear", accel), closed_form(accel, mu_g, 1e-3), 1e-6) << accel;
  }
}

// The belt runs up a slope: gravity takes its share of the friction.
TEST_P(BreakUp, GearOnATiltedPlate) {
  const double tilt = 0.1, mu = 0.3, g = 9.81;
  const double limit = g * (mu * std::cos(tilt) - std::sin(tilt));
  for (const double accel : {0.0, 0.99 * limit, 1.01 * limit, 1.5 * limit}) {
    auto scene = plate_scene(GetParam());
    const Eigen::Quaterniond q(Eigen::AngleAxisd(-tilt, Eigen::Vector3d::UnitY()));
    scene.conveyor->X_WC.q = q;
    scene.trays[0].X_WP = {q * scene.trays[0].X_WP.p, q};
    stand_gear(scene, "gear", 0, 0, 0);
    scene.gears[0].X_WP = {q * Eigen::Vector3d(0, 0, 0.022), q};
    Bench bench(std::move(scene));
    bench.run(200);
    EXPECT_NEAR(slip(bench, "gear", accel), closed_form(accel, limit, 1e-3), 1e-6) << accel;
  }
}

TEST_P(BreakUp, TrayOnTheBelt) {
  const double mu_g = 0.4 * 9.81;
  for (const double accel : {3.9, 3.96, 5.0}) {
    auto scene = plate_scene(GetParam());
    scene.physics.friction.tray_belt = 0.4;
    scene.physics.friction.gear_tray = 0.9;
    add_tray(scene, "loaded", "small4", {0.5, 0}, {"s1=g1", "s2=g2", "s3=g3"});
    Bench bench(std::move(scene));
    bench.run(200);
    const double start = bench.X_WB("loaded").translation().x();
    for (int i = 1; i <= 100; ++i) {
      bench.world->set_belt_speed(accel * 1e-3 * i);
      bench.run(1);
    }
    const double belt = 0.5 * accel * 1e-6 * 100 * 101;
    const double lag = belt - (bench.X_WB("loaded").translation().x() - start);
    EXPECT_NEAR(lag, closed_form(accel, mu_g, 1e-3), 1e-6) << accel;
  }
}

INSTANTIATE_TEST_SUITE_P(Simplification, BreakUp,
                         testing::Values(Simplification::kOff, Simplification::kMerge,
                                         Simplification::kDormant));

// No break below the limit: the group stays one body all the time.
TEST(BreakUpMerged, NoneBelowTheLimit) {
  for (const double accel : {1.0, 2.0, 2.9, 2.94}) {
    auto scene = plate_scene(Simplification::kMerge);
    stand_gear(scene, "gear", 0, 0, 0.022);
    Bench bench(std::move(scene));
    bench.run(200);
    for (int i = 1; i <= 100; ++i) {
      bench.world->set_belt_speed(accel * 1e-3 * i);
      bench.run(1);
      ASSERT_EQ(bench.world->body(1).group_kind, api::GroupKind::kMerged) << accel << " at " << i;
    }
  }
}

// While it slides it is on its own, also when it is slow or about to stop; then it is merged anew.
TEST(BreakUpMerged, NotMergedWhileSliding) {
  auto scene = plate_scene(Simplification::kMerge);
  stand_gear(scene, "gear", 0, 0, 0.022);
  Bench bench(std::move(scene));
  bench.run(200);
  slip(bench, "gear", 3.0);
  EXPECT_EQ(bench.world->body(1).group, -1);
  const double relative = bench.world->body(0).v_W.x() - bench.world->body(1).v_W.x();
  EXPECT_NEAR(relative, (3.0 - 2.943) * 0.1, 1e-5);
  bench.run(100);  // constant speed: it stops within 2 ms
  EXPECT_GE(bench.world->body(1).group, 0);
  EXPECT_NEAR(bench.world->body(1).v_W.x(), 0.3, 1e-8);  // as exactly as contacts are solved
}

// A gear on a gear on the plate, the upper one with less friction than its carrier needs.
TEST(BreakUpMerged, StackBreaksWhereItIsWeakest) {
  for (const double accel : {1.9, 2.2}) {
    auto scene = plate_scene(Simplification::kMerge);
    scene.physics.friction.gear_tray = 0.8;
    scene.physics.friction.gear_gear = 0.21;
    // A flat puck to stand on: a gear type without a peg.
    auto puck = gear_type("large");
    puck.name = "puck";
    puck.peg_top_m = puck.disc_height_m;
    scene.gear_types["puck"] = puck;
    stand_gear(scene, "low", 0, 0, 0.022);
    scene.gears[0].type = "puck";
    stand_gear(scene, "high", 0, 0, 0.040);
    scene.gears[1].type = "puck";
    Bench bench(std::move(scene));
    bench.run(300);
    ASSERT_EQ(bench.world->body(2).group_kind, api::GroupKind::kMerged);
    const double moved = slip(bench, "high", accel);
    EXPECT_NEAR(moved, closed_form(accel, 0.21 * 9.81, 1e-3), 1e-6) << accel;
    EXPECT_LT(std::abs((bench.X_WB("plate").inverse() * bench.X_WB("low")).translation().x()),
              1e-6);
  }
}

}  // namespace
}  // namespace aprsim::physics::test
