// The gripper's law and contact simplification on every engine.

#include <algorithm>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/parameter_names.hpp"
#include "tests/unit/world/physics/cell_builder.hpp"
#include "tests/unit/world/physics/engine/engine_cases.hpp"

namespace aprsim::physics::test {
namespace {

using scene::Simplification;

class CellOnEveryEngine : public testing::TestWithParam<EngineCase> {
 protected:
  [[nodiscard]] scene::Scene empty() const {
    scene::Scene scene = empty_scene();
    GetParam().apply(scene.physics);
    return scene;
  }
  /// A gear on a table, with a hand around its peg.
  [[nodiscard]] scene::Scene pick(double pad_friction) const {
    scene::Scene scene = empty();
    add_table(scene);
    Pose pose;
    pose.p.z() = scene.gear_types.at("small").hub_height_m;
    add_gear(scene, "g", "small", pose);
    const double tip = pose.p.z() + scene.gear_types.at("small").disc_height_m + 3.5e-3;
    scene::Gripper& gripper = add_hand(scene, {0, 0, tip}).gripper;
    gripper.pad = scene::PadShape::kFlat;
    gripper.pad_friction = pad_friction;
    return scene;
  }
};

TEST_P(CellOnEveryEngine, AGripperHoldsAGearByFrictionWhileItIsLifted) {
  Bench bench(pick(0.7));
  bench.run(50);
  bench.grip(0);
  ASSERT_TRUE(bench.world->gripper(0).holding);
  for (const double force : bench.world->gripper(0).force_n) EXPECT_NEAR(force, 60, 2);
  const Eigen::Isometry3d X_TG = bench.X_TB("g");
  bench.move({0.05, 0.02, 0.1}, 0.5);
  bench.run(200);
  EXPECT_TRUE(bench.world->gripper(0).holding);
  EXPECT_LT((bench.X_TB("g").translation() - X_TG.translation()).norm(),
            GetParam().is_ode() ? 2e-3 : 1e-7);
  bench.grip(1);
  bench.run(500);
  EXPECT_FALSE(bench.world->gripper(0).holding);
  EXPECT_LT(bench.X_WB("g").translation().z(), 0.05);
}

TEST_P(CellOnEveryEngine, WithoutFrictionItStaysOnTheTable) {
  Bench bench(pick(1e-4));
  bench.run(50);
  bench.grip(0);
  bench.move({0, 0, 0.1}, 0.5);
  EXPECT_LT(bench.X_WB("g").translation().z(), 0.05);
}

// Both laws of the paper and its baselines need joint forces only.
TEST_P(CellOnEveryEngine, EveryLawOfTheGripperCloses) {
  for (const auto law : {scene::GripperLaw::kConstant, scene::GripperLaw::kMimicPid,
                         scene::GripperLaw::kCoupled, scene::GripperLaw::kLinkage}) {
    scene::Scene scene = pick(0.7);
    scene.robots[0].gripper.law = law;
    Bench bench(std::move(scene));
    bench.run(50);
    bench.grip(0);
    EXPECT_TRUE(bench.world->gripper(0).holding) << static_cast<int>(law);
    EXPECT_NEAR(bench.world->gripper(0).force_n[0], 60, 3) << static_cast<int>(law);
  }
}

/// A full tray and another one on a belt, and a hand over a gear.
scene::Scene busy_on_belt(const EngineCase& engine, Simplification mode) {
  scene::Scene scene = empty_scene();
  engine.apply(scene.physics);
  scene.physics.simplification = mode;
  add_belt(scene);
  add_busy_bodies(scene);
  return scene;
}

/// Picks gear g1, lifts it and starts the belt.
void pick_then_ride(Bench& bench, int step) {
  constexpr double kDownPerStep = 0.05 / 150;
  Eigen::Isometry3d X_WT = bench.X_WT;
  if (step < 150) X_WT.translation().z() -= kDownPerStep;
  if (step == 160) bench.world->set_gripper(0, 0);
  if (step >= 400 && step < 550) X_WT.translation().z() += kDownPerStep;
  if (step >= 450) bench.world->set_belt_speed(5e-4 * std::min(step - 450, 200));
  bench.step_tool(X_WT);
}

TEST_P(CellOnEveryEngine, VirtualJointsHoldAndBreak) {
  Bench bench(busy_on_belt(GetParam(), Simplification::kVirtualJoints));
  bench.run(400);
  // Four gears on one tray, one on the other.
  EXPECT_EQ(bench.world->virtual_joint_count(), 5);
  const auto joined = [&](const char* body) {
    return bench.world->grouping(bench.index_of(body)).joined;
  };
  EXPECT_GE(joined("g1"), 0);
  for (int step = 0; step < 700; ++step) pick_then_ride(bench, step);
  // Lifted, without its joint; the others ride with their tray.
  EXPECT_EQ(joined("g1"), -1);
  EXPECT_GT(bench.X_WB("g1").translation().z(), 0.05);
  EXPECT_GE(joined("g2"), 0);
  const Eigen::Isometry3d apart = bench.X_WB("a").inverse() * bench.X_WB("g2");
  for (int step = 700; step < 1000; ++step) pick_then_ride(bench, step);
  const Eigen::Isometry3d later = bench.X_WB("a").inverse() * bench.X_WB("g2");
  EXPECT_LT((later.translation() - apart.translation()).norm(), 1e-5);
  EXPECT_GT(bench.X_WB("a").translation().x(), 0.03);
}

TEST_P(CellOnEveryEngine, EveryModeCarriesATrayWithItsGears) {
  for (const auto mode : {Simplification::kOff, Simplification::kVirtualJoints,
                          Simplification::kMerge, Simplification::kDormant}) {
    SCOPED_TRACE(testing::PrintToString(mode));
    Bench bench(busy_on_belt(GetParam(), mode));
    bench.run(600);
    const Eigen::Isometry3d before = bench.X_WB("a").inverse() * bench.X_WB("g2");
    const double start = bench.X_WB("a").translation().x();
    for (int i = 1; i <= 1000; ++i) {
      bench.world->set_belt_speed(2e-4 * std::min(i, 500));
      bench.run(1);
    }
    const Eigen::Isometry3d after = bench.X_WB("a").inverse() * bench.X_WB("g2");
    EXPECT_LT((after.translation() - before.translation()).norm(),
              GetParam().is_ode() ? 1e-3 : 1e-7);
    EXPECT_NEAR(bench.X_WB("a").translation().x() - start, 0.075, 1e-3);
    EXPECT_EQ(bench.world->solver_failures().not_converged, 0u);
  }
}

TEST_P(CellOnEveryEngine, SavedStatesGoOnBitForBit) {
  for (const auto mode : {Simplification::kVirtualJoints, Simplification::kDormant}) {
    SCOPED_TRACE(testing::PrintToString(mode));
    Bench first(busy_on_belt(GetParam(), mode)), fresh(busy_on_belt(GetParam(), mode));
    first.run(120);
    for (int step = 0; step < 190; ++step) pick_then_ride(first, step);
    const PhysicsWorld::State state = first.world->save();
    const Eigen::Isometry3d X_WT = first.X_WT;
    for (int step = 190; step < 600; ++step) pick_then_ride(first, step);
    const std::uint64_t expected = first.world->state_hash();
    for (Bench* bench : {&first, &fresh}) {
      bench->world->restore(state);
      bench->X_WT = X_WT;
      for (int step = 190; step < 600; ++step) pick_then_ride(*bench, step);
      EXPECT_EQ(bench->world->state_hash(), expected);
    }
  }
}

TEST_P(CellOnEveryEngine, OneBodysFailureIsThatBodysLoss) {
  Bench bench(busy_on_belt(GetParam(), Simplification::kOff));
  bench.run(300);
  // Faster than anything in a cell: the motion has diverged. It flies up and away.
  bench.world->set_velocity(bench.index_of("loose"), {0, 0, 600}, Eigen::Vector3d::Zero());
  bench.run(300);
  for (int i = 0; i < bench.world->body_count(); ++i) {
    EXPECT_EQ(bench.world->lost(i), i == bench.index_of("loose")) << i;
    EXPECT_LT(bench.world->body(i).v_W.norm(), 1e-3);
  }
}

INSTANTIATE_TEST_SUITE_P(Engines, CellOnEveryEngine, testing::ValuesIn(kEngines),
                         testing::PrintToStringParamName());

}  // namespace
}  // namespace aprsim::physics::test
