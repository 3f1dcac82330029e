#include <limits>

#include <gtest/gtest.h>

#include "tests/unit/world/physics/cell_builder.hpp"

namespace aprsim::physics::test {
namespace {

TEST(DivergenceCheck, NotANumberIsReportedInsteadOfEndingTheProcess) {
  auto scene = empty_scene();
  add_table(scene);
  add_tray(scene, "tray", "small4", {0, 0}, {"s1=g1"});
  scene.gears[0].X_WP.p.x() = std::numeric_limits<double>::quiet_NaN();
  Bench bench(std::move(scene));
  try {
    bench.run(1);
    FAIL() << "no exception";
  } catch (const PhysicsFailure& failure) {
    const std::string what = failure.what();
    EXPECT_NE(what.find("g1"), std::string::npos) << what;
    EXPECT_NE(what.find("step 1"), std::string::npos) << what;
  }
}

TEST(DivergenceCheck, RunawaySpeedIsReported) {
  auto scene = empty_scene();
  add_table(scene);
  Pose high;
  high.p.z() = 1000;
  add_gear(scene, "meteor", "small", high);
  Bench bench(std::move(scene));
  try {
    bench.run(8000);  // 50 m/s are reached 127 m further down
    FAIL() << "no exception";
  } catch (const PhysicsFailure& failure) {
    const std::string what = failure.what();
    EXPECT_NE(what.find("meteor"), std::string::npos) << what;
    EXPECT_NE(what.find("50"), std::string::npos) << what;
  }
}

// Started 2 mm deep in the table: counted, reported, pushed out without an explosion.
TEST(DivergenceCheck, PenetrationIsCounted) {
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
