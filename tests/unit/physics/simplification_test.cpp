#include <gtest/gtest.h>

#include "tests/unit/physics/cell_builder.hpp"

namespace aprsim::physics::test {
namespace {

scene::Scene tray_of_four(scene::Simplification simplification) {
  auto scene = empty_scene();
  scene.physics.simplification = simplification;
  add_table(scene);
  add_tray(scene, "tray", "small4", {0, 0}, {"s1=g1", "s2=g2", "s3=g3", "s4=g4"});
  return scene;
}

TEST(VirtualJoints, ReplaceContactsAtRestAndAreAbsentWhenOff) {
  Bench on(tray_of_four(scene::Simplification::kDormant));
  Bench off(tray_of_four(scene::Simplification::kOff));
  on.run(300);
  off.run(300);
  EXPECT_EQ(on.world->virtual_joint_count(), 5);
  EXPECT_EQ(on.world->contact_count(), 0);
  EXPECT_EQ(off.world->virtual_joint_count(), 0);
  EXPECT_GT(off.world->contact_count(), 15);
  for (const char* body : {"tray", "g1", "g2", "g3", "g4"}) {
    EXPECT_LT((on.X_WB(body).translation() - off.X_WB(body).translation()).norm(), 5e-6) << body;
  }
}

TEST(VirtualJoints, AtRestNothingChangesABit) {
  Bench bench(tray_of_four(scene::Simplification::kDormant));
  bench.run(300);
  const std::uint64_t hash = bench.world->state_hash();
  bench.run(1000);
  EXPECT_EQ(bench.world->state_hash(), hash);
}

// A second gear dropped on a gear at rest: what rests must wake and take part.
TEST(VirtualJoints, WakeWhenAFreeBodyLandsOnThem) {
  auto scene = tray_of_four(scene::Simplification::kDormant);
  Pose above = scene.gears[0].X_WP;
  above.p.z() += 0.2;
  add_gear(scene, "falling", "large", above);
  Bench bench(std::move(scene));
  bench.run(150);
  EXPECT_GE(bench.world->virtual_joint_count(), 5);
  bool woke = false;
  for (int i = 0; i < 200; ++i) {
    bench.run(1);
    woke = woke || !bench.world->body(bench.index_of("g1")).resting;
  }
  EXPECT_TRUE(woke);
  // The large gear's hub can not sink into the peg: no tunnelling.
  EXPECT_GT(bench.X_WB("falling").translation().z(), 0.02);
}

// The paper's pair criterion holds for pairs that move together: on a starting belt the joints
// stay, and the gears do not move in their tray.
TEST(VirtualJoints, HoldOnAStartingBelt) {
  auto scene = empty_scene();
  add_belt(scene);
  add_tray(scene, "tray", "small4", {-0.5, 0}, {"s1=g1", "s2=g2", "s3=g3", "s4=g4"});
  Bench bench(std::move(scene));
  bench.run(300);
  double speed = 0;
  for (int i = 0; i < 400; ++i) {
    speed += 0.5e-3;
    bench.world->set_belt_speed(speed);
    bench.run(1);
    ASSERT_GE(bench.world->virtual_joint_count(), 4) << "at " << i;
  }
  bench.run(200);
  EXPECT_EQ(bench.world->virtual_joint_count(), 5);  // rides: the tray is parked on the belt too
  EXPECT_NEAR(bench.world->body(0).v_W.x(), 0.2, 1e-9);
  EXPECT_TRUE(bench.world->body(0).resting);
}

// Algorithm 2: a joint goes when the force on the pair departs from what it was made for. The
// belt's start at 9 m/s^2 asks 0.3 N of the large gear's contact.
TEST(VirtualJoints, AreReleasedWhenTheForceChanges) {
  auto scene = empty_scene();
  scene.physics.simplify_force_n = 0.02;
  add_belt(scene);
  add_tray(scene, "tray", "small4", {-0.5, 0}, {"s1=g1"});
  Bench bench(std::move(scene));
  bench.run(300);
  ASSERT_EQ(bench.world->virtual_joint_count(), 2);
  int fewest = 2;
  double speed = 0;
  for (int i = 0; i < 50; ++i) {
    speed += 4e-3;  // 4 m/s^2: 0.04 N on 10 g
    bench.world->set_belt_speed(speed);
    bench.run(1);
    fewest = std::min(fewest, bench.world->virtual_joint_count());
  }
  EXPECT_EQ(fewest, 0);
}

TEST(VirtualJoints, GripperFreesWhatItTouches) {
  auto scene = tray_of_four(scene::Simplification::kDormant);
  add_hand(scene, {-0.045, 0.045, 0.0245 + 0.05});
  Bench bench(std::move(scene));
  bench.run(300);
  bench.move({0, 0, -0.05}, 0.15);
  EXPECT_EQ(bench.world->virtual_joint_count(), 5);
  bench.grip(0);
  EXPECT_TRUE(bench.world->gripper(0).holding);
  // The gripped gear and the tray are free, the neighbours still hang on the tray.
  EXPECT_EQ(bench.world->virtual_joint_count(), 3);
  EXPECT_FALSE(bench.world->body(bench.index_of("g1")).resting);
  bench.move({0, 0, 0.05}, 0.2);
  bench.run(200);
  EXPECT_EQ(bench.world->virtual_joint_count(), 4);
  EXPECT_TRUE(bench.world->body(0).resting);
}

}  // namespace
}  // namespace aprsim::physics::test
