#include <gtest/gtest.h>

#include "tests/support/parameter_names.hpp"
#include "tests/unit/world/physics/cell_builder.hpp"

namespace aprsim::physics::test {
namespace {

Pose tilted(const Eigen::Vector3d& p, double angle_rad) {
  Pose pose;
  pose.p = p;
  pose.q = Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitX());
  return pose;
}

class DroppedGear : public testing::TestWithParam<std::tuple<const char*, scene::Simplification>> {
};

// A gear let go 1 mm above its pocket and 0.1 mm beside it, within the clearance.
TEST_P(DroppedGear, RestsAtItsPlaceAndStaysThere) {
  const auto [type, simplification] = GetParam();
  auto scene = empty_scene();
  scene.physics.simplification = simplification;
  add_table(scene);
  add_tray(scene, "tray", std::string(type) + "4", {0, 0}, {"s1=gear"});
  const Eigen::Vector3d nominal = scene.gears[0].X_WP.p;
  scene.gears[0].X_WP.p += Eigen::Vector3d(1e-4, 0, 1e-3);
  Bench bench(std::move(scene));
  bench.run(500);
  const Eigen::Vector3d settled = bench.X_WB("gear").translation();
  // Bodies rest up to two surface layers of 10 um deep: tray on table, gear on tray.
  EXPECT_NEAR(settled.z(), nominal.z(), 25e-6);
  EXPECT_LT((settled - nominal).head<2>().norm(), 0.25e-3);
  EXPECT_TRUE(bench.world->body(1).resting);
  bench.run(1000);
  EXPECT_LT((bench.X_WB("gear").translation() - settled).norm(), 1.5e-7);
  EXPECT_EQ(bench.world->penetration_faults(), 0u);
}

INSTANTIATE_TEST_SUITE_P(Types, DroppedGear,
                         testing::Combine(testing::Values("small", "medium", "d60"),
                                          testing::Values(scene::Simplification::kOff,
                                                          scene::Simplification::kVirtualJoints,
                                                          scene::Simplification::kMerge,
                                                          scene::Simplification::kDormant)));

TEST(Rest, GearBesideItsPocketFallsInWhenItsHubReachesTheMouth) {
  auto scene = empty_scene();
  add_table(scene);
  add_tray(scene, "tray", "small4", {0, 0}, {"s1=gear"});
  scene.gears[0].X_WP.p += Eigen::Vector3d(3e-3, 0, 12e-3);  // the cone guides it 3 mm
  Bench bench(std::move(scene));
  bench.run(1500);
  EXPECT_NEAR(bench.X_WB("gear").translation().x(), -0.045, 0.3e-3);
  EXPECT_NEAR(bench.X_WB("gear").translation().z(), 0.015, 0.3e-3);
}

TEST(Rest, LooseGearOnTableRollsOutAndRests) {
  auto scene = empty_scene();
  add_table(scene);
  add_gear(scene, "gear", "small", tilted({0, 0, 0.06}, 1.2));
  Bench bench(std::move(scene));
  bench.run(4000);
  const BodyState state = bench.world->body(0);
  EXPECT_GT(state.p_WB.z(), 0);
  EXPECT_LT(state.p_WB.z(), 0.04);
  EXPECT_LT(state.v_W.norm(), 0.05);
  EXPECT_EQ(bench.world->penetration_faults(), 0u);
}

/// Solved loosely, what lies drifts within the tolerance, and is put right now and then; only then
/// are forces searched for.
TEST(Rest, LoosenessSparesSolutionsOfWhatLies) {
  auto scene = empty_scene();
  scene.physics.simplification = scene::Simplification::kOff;
  scene.physics.residual_m_s = 1e-5;
  add_table(scene);
  add_tray(scene, "tray", "small4", {0, 0}, {"s1=a", "s2=b", "s3=c"});
  for (auto& gear : scene.gears) gear.X_WP.p += Eigen::Vector3d(1e-4, 5e-5, 1e-3);
  add_gear(scene, "lying", "medium", tilted({0.3, 0, 0.03}, 2.9));
  Bench bench(std::move(scene));
  bench.run(4000);
  const api::SolverWork before = bench.world->solver_work();
  constexpr int kSteps = 2000;
  bench.run(kSteps);
  const api::SolverWork& now = bench.world->solver_work();
  EXPECT_EQ(now.solved - before.solved, 2u * kSteps);
  EXPECT_LT(now.iterations - before.iterations, std::uint64_t{kSteps} / 3);
  EXPECT_LT(bench.world->body(bench.index_of("lying")).v_W.norm(), 1e-4);
}

TEST(Rest, TrayStackedOnTraysRestsAndIsReportedResting) {
  auto scene = empty_scene();
  add_table(scene);
  add_tray(scene, "low", "small4", {0, 0}, {});
  add_tray(scene, "high", "small4", {0.03, 0}, {});
  scene.trays[1].X_WP.p.z() = 0.0305;
  Bench bench(std::move(scene));
  bench.run(500);
  EXPECT_NEAR(bench.X_WB("high").translation().z(), 0.030, 30e-6);
  EXPECT_TRUE(bench.world->body(0).resting);
  EXPECT_TRUE(bench.world->body(1).resting);
}

}  // namespace
}  // namespace aprsim::physics::test
