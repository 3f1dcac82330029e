// Tools without a robot are bodies like any other: they fall, stand in forks, are loaded and taken
// again where they are.

#include "world/physics/model/tool_changes.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/parameter_names.hpp"
#include "tests/unit/world/physics/cell_builder.hpp"

namespace aprsim::physics::test {
namespace {

using Eigen::Vector3d;

constexpr double kGrip = 0.0245;  // height of a grip over the table, on a small gear in its tray
constexpr double kKg = 0.6;       // of the hand

/// A fork under the palm of the hand that hangs at `tip`, its bars `gap_below` under the palm.
void add_fork(scene::Scene& scene, const Vector3d& tip, double gap_below) {
  const auto& gripper = scene.robots[0].gripper;
  for (const double side : {-1.0, 1.0}) {
    Pose X_WS;
    X_WS.p = tip + Vector3d(side * 0.03, 0, gripper.pad_height_m - gap_below - 0.01);
    scene.fixed.push_back({side < 0 ? "fork_1" : "fork_2", {0.03, 0.12, 0.02}, X_WS});
  }
}

scene::Scene fork_scene(double gap_below, scene::Simplification mode) {
  auto scene = empty_scene();
  scene.physics.simplification = mode;
  add_table(scene);
  add_hand(scene, {0, 0, 0.3});
  add_fork(scene, {0, 0, 0.3}, gap_below);
  return scene;
}

class ToolInFork : public testing::TestWithParam<scene::Simplification> {};

TEST_P(ToolInFork, StandsStillWithItsWeightOnTheBars) {
  Bench bench(fork_scene(5e-4, GetParam()));
  bench.run(10);
  const Eigen::Isometry3d X_before = bench.X_WT;
  bench.world->detach_tool(0);
  EXPECT_EQ(bench.world->tool_of(0), -1);
  bench.run(1500);
  const BodyState tool = bench.world->tool(0);
  EXPECT_NEAR(tool.p_WB.z(), X_before.translation().z() - 5e-4, 5e-5);
  EXPECT_LT((tool.p_WB - X_before.translation()).head<2>().norm(), 1e-4);
  EXPECT_TRUE(tool.resting);
  std::vector<api::ContactSnapshot> contacts;
  bench.world->write_contacts(contacts);
  double load = 0;
  for (const auto& contact : contacts) {
    if (contact.first.kind != api::ContactSide::Kind::kTool) continue;
    EXPECT_EQ(contact.first.index, 0);
    load += contact.f_W.z();
  }
  EXPECT_NEAR(load, kKg * 9.81, 0.05);
  EXPECT_EQ(bench.world->penetration_faults(), 0u);
}

TEST_P(ToolInFork, IsTakenWhereItIsAndWorksAgain) {
  auto scene = fork_scene(5e-4, GetParam());
  Bench bench(std::move(scene));
  bench.run(10);
  bench.world->detach_tool(0);
  bench.run(500);
  const BodyState left = bench.world->tool(0);
  const Eigen::Isometry3d X_WT = Pose{left.p_WB, left.q_WB}.isometry();
  bench.world->attach_tool(0, 0, X_WT * bench.scene.robots[0].X_FT.isometry().inverse());
  EXPECT_EQ(bench.world->tool_of(0), 0);
  bench.step_tool(X_WT);
  EXPECT_LT((bench.world->tool(0).p_WB - left.p_WB).norm(), 1e-5);
  bench.move({0, 0, 0.1}, 0.3);
  EXPECT_LT((bench.world->tool(0).p_WB - bench.X_WT.translation()).norm(), 1e-5);
  bench.grip(0);
  EXPECT_NEAR(bench.world->opening(0), 0.002, 1e-5);
  EXPECT_NEAR(bench.world->gripper(0).separation_m, 0.002, 1e-5);
  EXPECT_TRUE(bench.world->gripper(0).settled);
}

INSTANTIATE_TEST_SUITE_P(Modes, ToolInFork,
                         testing::Values(scene::Simplification::kDormant,
                                         scene::Simplification::kOff),
                         [](const auto& mode) {
                           return mode.param == scene::Simplification::kOff ? "off" : "dormant";
                         });

// The fall of a rigid body, and a landing beside what it held.
TEST(ToolChanges, InTheAirTheToolFallsAndItsPartWithIt) {
  auto scene = empty_scene();
  add_table(scene);
  add_tray(scene, "tray", "small4", {0, 0}, {"s1=g"});
  add_hand(scene, Vector3d(-0.045, 0.045, kGrip));
  Bench bench(std::move(scene));
  bench.run(50);
  bench.grip(0);
  ASSERT_TRUE(bench.world->gripper(0).holding);
  bench.move({0.2, 0.2, 0.3}, 0.6);
  ASSERT_TRUE(bench.world->gripper(0).holding);
  bench.run(100);
  const double tool_z = bench.world->tool(0).p_WB.z();
  const double gear_z = bench.X_WB("g").translation().z();
  const std::uint64_t faults = bench.world->penetration_faults();
  bench.world->detach_tool(0);
  EXPECT_FALSE(bench.world->gripper(0).holding);
  bench.run(100);
  const double fall = 0.5 * 9.81 * 0.1 * 0.1;
  EXPECT_NEAR(bench.world->tool(0).p_WB.z(), tool_z - fall, 0.002);
  EXPECT_NEAR(bench.X_WB("g").translation().z(), gear_z - fall, 0.002);
  EXPECT_EQ(bench.world->penetration_faults(), faults) << "nothing is pushed apart";
  bench.run(3000);
  EXPECT_LT(bench.world->tool(0).p_WB.z(), 0.2);
  EXPECT_GT(bench.world->tool(0).p_WB.z(), 0);
  EXPECT_LT(bench.X_WB("g").translation().z(), 0.15);
  EXPECT_GT(bench.X_WB("g").translation().z(), 0);
  EXPECT_TRUE(bench.world->tool(0).resting);
}

TEST(ToolChanges, ALetGoToolMovesOnAsItsRobotDid) {
  auto scene = empty_scene();
  add_table(scene);
  add_hand(scene, {0, 0, 0.8});
  Bench bench(std::move(scene));
  Eigen::Isometry3d X_WT = bench.X_WT;
  for (int i = 0; i < 200; ++i) {
    X_WT.translation().x() += 5e-4;
    bench.step_tool(X_WT);
  }
  bench.world->detach_tool(0);
  const Vector3d from = bench.world->tool(0).p_WB;
  EXPECT_NEAR(bench.world->tool(0).v_W.x(), 0.5, 1e-6);
  bench.run(200);
  EXPECT_NEAR(bench.world->tool(0).p_WB.x() - from.x(), 0.1, 1e-3);
}

TEST(ToolChanges, AnEmptyFlangeTouchesNothing) {
  auto scene = empty_scene();
  add_table(scene);
  add_hand(scene, {0, 0, 0.1});
  Bench bench(std::move(scene));
  bench.run(5);
  bench.world->detach_tool(0);
  bench.run(1000);
  const Eigen::Isometry3d start = bench.X_WT;
  bench.move({0.5, 0, -0.05}, 0.5);  // the tip's place is in the table then
  bench.world->set_gripper(0, 0);
  bench.run(50);
  EXPECT_TRUE(bench.world->arm_forces(0).empty());
  EXPECT_FALSE(bench.world->gripper(0).holding);
  EXPECT_GT((bench.X_WT.translation() - start.translation()).norm(), 0.4);
}

TEST(ToolChanges, SavedStatesHaveTheToolsWhereTheyWere) {
  Bench first(fork_scene(1e-3, scene::Simplification::kDormant));
  first.run(10);
  const PhysicsWorld::State mounted = first.world->save();
  first.world->set_gripper(0, 0);
  first.run(60);  // half closed
  first.world->detach_tool(0);
  first.run(20);
  const PhysicsWorld::State falling = first.world->save();
  first.run(400);
  const std::uint64_t rest = first.world->state_hash();
  const double opening = first.world->opening(0);
  Bench fresh(fork_scene(1e-3, scene::Simplification::kDormant));
  for (Bench* bench : {&first, &fresh}) {
    bench->world->restore(falling);
    EXPECT_EQ(bench->world->tool_of(0), -1);
    bench->run(400);
    EXPECT_EQ(bench->world->state_hash(), rest);
    EXPECT_EQ(bench->world->opening(0), opening);
    bench->world->restore(mounted);
    EXPECT_EQ(bench->world->tool_of(0), 0);
    bench->world->set_gripper(0, 0);
    bench->run(60);
    bench->world->detach_tool(0);
    bench->run(420);
    EXPECT_EQ(bench->world->state_hash(), rest);
  }
}

// Two hands, one tool after the other on the same flange.
TEST(ToolChanges, AnotherToolHasItsOwnShapeAndForce) {
  auto scene = empty_scene();
  add_table(scene);
  add_hand(scene, {0, 0, 0.5});
  scene::Tool strong;
  strong.name = "strong";
  strong.gripper = scene.robots[0].gripper;
  strong.gripper.gap_open_m = 0.032;
  strong.gripper.gap_closed_m = 0.012;
  strong.X_QT.p = {0, 0, 0.15};
  strong.X_WQ.p = {0.5, 0, 0.15};
  strong.X_WQ.q = Eigen::AngleAxisd(M_PI, Vector3d::UnitX());
  scene.tools.push_back(strong);
  Bench bench(std::move(scene));
  ASSERT_EQ(bench.world->tool_count(), 2);
  EXPECT_EQ(bench.world->tool_of(0), 1) << "the listed tools come first";
  bench.run(1);
  bench.world->detach_tool(0);
  bench.run(1);
  const BodyState stands = bench.world->tool(0);
  const Eigen::Isometry3d X_WQ =
      Pose{stands.p_WB, stands.q_WB}.isometry() * strong.X_QT.isometry().inverse();
  bench.world->attach_tool(0, 0, X_WQ);
  bench.run(5);
  EXPECT_NEAR(bench.world->gripper(0).separation_m, 0.032, 5e-5);
  bench.grip(0);
  EXPECT_NEAR(bench.world->gripper(0).separation_m, 0.012, 1e-5);
  EXPECT_NEAR((bench.world->gripper(0).X_WT.p - X_WQ.translation()).norm(), 0.15, 1e-4);
}

}  // namespace
}  // namespace aprsim::physics::test
