#include <algorithm>

#include <gtest/gtest.h>

#include "tests/support/parameter_names.hpp"
#include "tests/unit/world/physics/cell_builder.hpp"

namespace aprsim::physics::test {
namespace {

constexpr double kAccel = 0.5;  // [m/s^2] of the drive

/// Ramps the belt from `from` to `to` and returns its travel.
double ramp(Bench& bench, double from, double to) {
  double travel = 0;
  double speed = from;
  while (speed != to) {
    const double step = kAccel * 1e-3;
    speed = to > speed ? std::min(to, speed + step) : std::max(to, speed - step);
    bench.world->set_belt_speed(speed);
    bench.run(1);
    travel += speed * 1e-3;
  }
  return travel;
}

class Belt : public testing::TestWithParam<scene::Simplification> {
 protected:
  static Bench loaded_belt(double tray_yaw = 0.2) {
    auto scene = empty_scene();
    scene.physics.simplification = GetParam();
    add_belt(scene);
    add_tray(scene, "tray", "small4", {-0.5, 0}, {"s1=g1", "s2=g2", "s3=g3", "s4=g4"}, tray_yaw);
    return Bench(std::move(scene));
  }
};

TEST_P(Belt, CarriesStopsAndReversesWhatLiesOnIt) {
  Bench bench = loaded_belt();
  bench.run(200);
  const double start = bench.X_WB("tray").translation().x();
  double travel = ramp(bench, 0, 0.25);
  bench.run(1000);
  travel += 0.25;
  EXPECT_NEAR(bench.world->body(0).v_W.x(), 0.25, 0.02 * 0.25);
  EXPECT_NEAR(bench.X_WB("tray").translation().x() - start, travel, 0.5e-3);
  travel += ramp(bench, 0.25, -0.1);
  bench.run(500);
  travel -= 0.05;
  EXPECT_NEAR(bench.world->body(0).v_W.x(), -0.1, 0.002);
  travel += ramp(bench, -0.1, 0);
  bench.run(300);
  EXPECT_LT(bench.world->body(0).v_W.norm(), 1e-6);
  EXPECT_NEAR(bench.X_WB("tray").translation().x() - start, travel, 1e-3);
}

TEST_P(Belt, GearsStayInTheirPockets) {
  Bench bench = loaded_belt();
  bench.run(200);
  const Eigen::Isometry3d before = bench.X_WB("tray").inverse() * bench.X_WB("g3");
  ramp(bench, 0, 0.3);
  bench.run(500);
  ramp(bench, 0.3, 0);
  bench.run(300);
  const Eigen::Isometry3d after = bench.X_WB("tray").inverse() * bench.X_WB("g3");
  EXPECT_LT((after.translation() - before.translation()).norm(), 5e-6);
}

TEST_P(Belt, HarshStartSlipsAsFrictionSays) {
  Bench bench = loaded_belt(0);
  bench.run(200);
  const double start = bench.X_WB("tray").translation().x();
  bench.world->set_belt_speed(0.5);  // at once
  bench.run(400);
  // Sliding until v = mu g t: the tray lags v^2 / (2 mu g) behind the belt.
  const double mu_g = bench.scene.physics.friction.tray_belt * bench.scene.physics.gravity_m_s2;
  const double lag = 0.5 * 0.4 - (bench.X_WB("tray").translation().x() - start);
  EXPECT_NEAR(lag, 0.5 * 0.5 / (2 * mu_g), 0.1e-3 + 0.05 * 0.25 / (2 * mu_g));
}

INSTANTIATE_TEST_SUITE_P(Simplification, Belt,
                         testing::Values(scene::Simplification::kOff,
                                         scene::Simplification::kVirtualJoints,
                                         scene::Simplification::kMerge,
                                         scene::Simplification::kDormant));

TEST(BeltEnd, TrayRunsOverTheEndAndFalls) {
  auto scene = empty_scene();
  add_belt(scene, 1.0);
  add_tray(scene, "tray", "small4", {0.3, 0}, {"s1=g1"});
  Bench bench(std::move(scene));
  bench.run(200);
  ramp(bench, 0, 0.3);
  bench.run(1500);
  EXPECT_LT(bench.X_WB("tray").translation().z(), -0.1);
}

TEST(BeltBlocked, TrayIsHeldByAStopWhileTheBeltRunsUnderIt) {
  auto scene = empty_scene();
  add_belt(scene);
  Pose stop;
  stop.p = {0.3, 0, 0.05};
  scene.fixed.push_back({"stop", {0.02, 0.5, 0.1}, stop});
  add_tray(scene, "tray", "small4", {0, 0}, {"s1=g1", "s4=g4"});
  Bench bench(std::move(scene));
  bench.run(200);
  ramp(bench, 0, 0.2);
  bench.run(2500);
  EXPECT_NEAR(bench.X_WB("tray").translation().x(), 0.3 - 0.01 - 0.08, 0.3e-3);
  EXPECT_LT(bench.world->body(0).v_W.norm(), 1e-3);
  EXPECT_LT(bench.world->max_penetration_m(), 0.5e-3);
}

}  // namespace
}  // namespace aprsim::physics::test
