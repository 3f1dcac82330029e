#include <optional>

#include <gtest/gtest.h>

#include "tests/support/parameter_names.hpp"
#include "tests/unit/world/physics/cell_builder.hpp"

namespace aprsim::physics::test {
namespace {

using scene::Simplification;

scene::Scene tray_of_four(Simplification simplification) {
  auto scene = empty_scene();
  scene.physics.simplification = simplification;
  add_table(scene);
  add_tray(scene, "tray", "small4", {0, 0}, {"s1=g1", "s2=g2", "s3=g3", "s4=g4"});
  return scene;
}

/// Drives the belt from one speed to another at `accel`.
void ramp(Bench& bench, double from, double to, double accel) {
  const int count = static_cast<int>(std::lround(std::abs(to - from) / accel / 1e-3));
  for (int i = 1; i <= count; ++i) {
    bench.world->set_belt_speed(from + (to - from) * i / count);
    bench.run(1);
  }
}

int count_of(const Bench& bench, api::GroupKind kind) {
  int count = 0;
  for (int i = 0; i < bench.world->body_count(); ++i) {
    if (bench.world->body(i).group_kind == kind) ++count;
  }
  return count;
}

// ---- all modes

class Modes : public testing::TestWithParam<Simplification> {};

TEST_P(Modes, LeaveBodiesWhereContactsHoldThemAndReportTheContacts) {
  Bench bench(tray_of_four(GetParam()));
  Bench off(tray_of_four(Simplification::kOff));
  bench.run(400);
  off.run(400);
  // A virtual joint keeps a gear wherever it was between falling and settling.
  const double near = GetParam() == Simplification::kVirtualJoints ? 25e-6 : 5e-6;
  for (const char* body : {"tray", "g1", "g2", "g3", "g4"}) {
    EXPECT_LT((bench.X_WB(body).translation() - off.X_WB(body).translation()).norm(), near) << body;
    EXPECT_TRUE(bench.world->body(bench.index_of(body)).resting) << body;
    EXPECT_TRUE(off.world->body(off.index_of(body)).resting) << body;
  }
  EXPECT_EQ(off.world->virtual_joint_count(), 0);
  EXPECT_EQ(count_of(off, api::GroupKind::kNone), 5);
  // A virtual joint hides its contacts: that is the paper's way.
  if (GetParam() != Simplification::kVirtualJoints) {
    EXPECT_EQ(bench.world->contact_count(), off.world->contact_count());
  }
}

INSTANTIATE_TEST_SUITE_P(Simplification, Modes,
                         testing::Values(Simplification::kVirtualJoints, Simplification::kMerge,
                                         Simplification::kDormant));

// ---- virtual joints

TEST(VirtualJoints, TieEveryRestingPairButNotToTheTable) {
  Bench bench(tray_of_four(Simplification::kVirtualJoints));
  bench.run(300);
  EXPECT_EQ(bench.world->virtual_joint_count(), 4);
  EXPECT_EQ(count_of(bench, api::GroupKind::kJoined), 5);
  EXPECT_EQ(bench.world->body(3).group, 0);
  EXPECT_EQ(bench.world->contact_count(), 4);  // tray on table
}

TEST(VirtualJoints, HoldOnAStartingBelt) {
  auto scene = empty_scene();
  scene.physics.simplification = Simplification::kVirtualJoints;
  add_belt(scene);
  add_tray(scene, "tray", "small4", {-0.5, 0}, {"s1=g1", "s2=g2", "s3=g3", "s4=g4"});
  Bench bench(std::move(scene));
  bench.run(300);
  ramp(bench, 0, 0.2, 0.5);
  EXPECT_EQ(bench.world->virtual_joint_count(), 4);
  bench.run(200);
  EXPECT_NEAR(bench.world->body(0).v_W.x(), 0.2, 1e-6);
}

// Algorithm 2: 4 m/s^2 ask 0.04 N of the contact of 10 g.
TEST(VirtualJoints, AreReleasedWhenTheForceChanges) {
  auto scene = empty_scene();
  scene.physics.simplification = Simplification::kVirtualJoints;
  scene.physics.simplify_force_n = 0.02;
  add_belt(scene);
  add_tray(scene, "tray", "small4", {-0.5, 0}, {"s1=g1"});
  Bench bench(std::move(scene));
  bench.run(300);
  ASSERT_EQ(bench.world->virtual_joint_count(), 1);
  int fewest = 1;
  for (int i = 1; i <= 50; ++i) {
    bench.world->set_belt_speed(4e-3 * i);
    bench.run(1);
    fewest = std::min(fewest, bench.world->virtual_joint_count());
  }
  EXPECT_EQ(fewest, 0);
}

// ---- merge

TEST(Merge, MakesOneBodyOfATrayAndItsGears) {
  Bench bench(tray_of_four(Simplification::kMerge));
  bench.run(300);
  EXPECT_EQ(bench.world->virtual_joint_count(), 4);
  EXPECT_EQ(count_of(bench, api::GroupKind::kMerged), 5);
  EXPECT_EQ(bench.world->body(4).group, 0);
}

// On a belt that starts and stops within friction, gears keep their place in the tray to rounding.
TEST(Merge, GearsRideWithTheirTray) {
  auto scene = empty_scene();
  scene.physics.simplification = Simplification::kMerge;
  add_belt(scene);
  add_tray(scene, "tray", "small4", {-0.5, 0.1}, {"s1=g1", "s2=g2", "s3=g3", "s4=g4"}, 0.3);
  Bench bench(std::move(scene));
  bench.run(300);
  const Eigen::Isometry3d before = bench.X_WB("tray").inverse() * bench.X_WB("g3");
  ramp(bench, 0, 0.2, 2.0);
  bench.run(500);
  ramp(bench, 0.2, 0, 2.0);
  EXPECT_EQ(count_of(bench, api::GroupKind::kMerged), 5);
  const Eigen::Isometry3d after = bench.X_WB("tray").inverse() * bench.X_WB("g3");
  EXPECT_LT((after.translation() - before.translation()).norm(), 1e-13);
}

TEST(Merge, GripperFreesTheGearThatItComesTo) {
  auto scene = tray_of_four(Simplification::kMerge);
  add_hand(scene, {-0.045, 0.045, 0.0245 + 0.05});
  Bench bench(std::move(scene));
  bench.run(300);
  bench.move({0, 0, -0.05}, 0.15);
  EXPECT_EQ(count_of(bench, api::GroupKind::kMerged), 4);
  EXPECT_EQ(bench.world->body(bench.index_of("g1")).group, -1);
  bench.grip(0);
  EXPECT_TRUE(bench.world->gripper(0).holding);
  bench.move({0, 0, 0.05}, 0.2);
  EXPECT_TRUE(bench.world->gripper(0).holding);
  EXPECT_GT(bench.X_WB("g1").translation().z(), 0.06);
  bench.run(200);
  EXPECT_EQ(count_of(bench, api::GroupKind::kMerged), 4);
  EXPECT_TRUE(bench.world->body(0).resting);
}

TEST(Merge, AGearThatFallsOnAnotherFreesIt) {
  auto scene = tray_of_four(Simplification::kMerge);
  Pose above = scene.gears[0].X_WP;
  above.p.z() += 0.2;
  add_gear(scene, "falling", "large", above);
  Bench bench(std::move(scene));
  bench.run(150);
  ASSERT_EQ(count_of(bench, api::GroupKind::kMerged), 5);
  bool freed = false;
  for (int i = 0; i < 200; ++i) {
    bench.run(1);
    freed = freed || bench.world->body(bench.index_of("g1")).group < 0;
  }
  EXPECT_TRUE(freed);
  EXPECT_GT(bench.X_WB("falling").translation().z(), 0.02);  // on top, not inside
}

// ---- dormant

TEST(Dormant, AtRestNothingChangesABit) {
  Bench bench(tray_of_four(Simplification::kDormant));
  bench.run(300);
  EXPECT_EQ(count_of(bench, api::GroupKind::kDormant), 5);
  const std::uint64_t hash = bench.world->state_hash();
  bench.run(1000);
  EXPECT_EQ(bench.world->state_hash(), hash);
}

TEST(Dormant, RidesTheBeltThroughStartAndStop) {
  auto scene = empty_scene();
  add_belt(scene);
  add_tray(scene, "tray", "small4", {-0.5, 0}, {"s1=g1", "s2=g2", "s3=g3", "s4=g4"});
  Bench bench(std::move(scene));
  bench.run(300);
  const double start = bench.X_WB("g2").translation().x();
  ramp(bench, 0, 0.2, 0.5);
  EXPECT_EQ(count_of(bench, api::GroupKind::kDormant), 5);
  EXPECT_DOUBLE_EQ(bench.world->body(2).v_W.x(), 0.2);
  bench.run(1000);
  ramp(bench, 0.2, 0, 0.5);
  EXPECT_EQ(count_of(bench, api::GroupKind::kDormant), 5);
  EXPECT_EQ(bench.world->body(2).v_W.norm(), 0);
  EXPECT_NEAR(bench.X_WB("g2").translation().x() - start, 0.2 * (0.4 + 1.0), 1e-8);
}

TEST(Dormant, WakesWhenTheBeltAsksMoreThanFrictionGives) {
  auto scene = empty_scene();
  add_belt(scene);
  add_tray(scene, "tray", "small4", {-0.5, 0}, {"s1=g1"});
  Bench bench(std::move(scene));
  bench.run(300);
  ASSERT_EQ(count_of(bench, api::GroupKind::kDormant), 2);
  bench.world->set_belt_speed(0.5);  // at once
  bench.run(1);
  EXPECT_EQ(count_of(bench, api::GroupKind::kDormant), 0);
  EXPECT_LT(bench.world->body(0).v_W.x(), 0.05);
}

TEST(Dormant, WakesBeforeItRunsIntoSomething) {
  auto scene = empty_scene();
  add_belt(scene);
  add_tray(scene, "tray", "small4", {0, 0}, {"s1=g1"});
  Pose stop;
  stop.p = {0.3, 0, 0.05};
  scene.fixed.push_back({"stop", {0.02, 0.5, 0.1}, stop});
  Bench bench(std::move(scene));
  bench.run(200);
  ramp(bench, 0, 0.2, 0.5);
  bool slept = false;
  for (int i = 0; i < 2000; ++i) {
    const double gap = 0.29 - 0.08 - bench.X_WB("tray").translation().x();
    const bool dormant = bench.world->body(0).group_kind == api::GroupKind::kDormant;
    slept = slept || (dormant && gap > 0.01);
    ASSERT_FALSE(dormant && gap < 5e-4) << gap;
    bench.run(1);
  }
  EXPECT_TRUE(slept);
  EXPECT_NEAR(bench.X_WB("tray").translation().x(), 0.21, 0.3e-3);
}

TEST(Dormant, WakesWhenAFreeBodyLandsOnIt) {
  auto scene = tray_of_four(Simplification::kDormant);
  Pose above = scene.gears[0].X_WP;
  above.p.z() += 0.2;
  add_gear(scene, "falling", "large", above);
  Bench bench(std::move(scene));
  bench.run(150);
  ASSERT_EQ(count_of(bench, api::GroupKind::kDormant), 5);
  int fewest = 5;
  for (int i = 0; i < 200; ++i) {
    bench.run(1);
    fewest = std::min(fewest, count_of(bench, api::GroupKind::kDormant));
  }
  EXPECT_EQ(fewest, 0);
  EXPECT_GT(bench.X_WB("falling").translation().z(), 0.02);
}

// A gear of a sleeping tray that is struck: all wake, it leaves its tray and flies.
TEST(Dormant, WakesWhenStruck) {
  Bench bench(tray_of_four(Simplification::kDormant));
  bench.run(300);
  ASSERT_EQ(count_of(bench, api::GroupKind::kDormant), 5);
  const int gear = bench.index_of("g2");
  bench.world->set_velocity(gear, {0, 0, 1}, {0, 0, 5});
  bench.run(10);
  EXPECT_EQ(bench.world->body(gear).group_kind, api::GroupKind::kNone);
  EXPECT_NEAR(bench.world->body(gear).v_W.z(), 1 - 9.81 * 0.01, 1e-9);
  EXPECT_NEAR(bench.world->body(gear).omega_W.z(), 5, 1e-9);
  EXPECT_LT(bench.world->body(bench.index_of("g1")).v_W.norm(), 1e-4);
}

TEST(Dormant, GripperWakesTheTrayThatItComesToAndNoOther) {
  auto scene = tray_of_four(Simplification::kDormant);
  add_tray(scene, "other", "small4", {0.3, 0}, {});
  add_hand(scene, {-0.045, 0.045, 0.0245 + 0.05});
  Bench bench(std::move(scene));
  bench.run(300);
  bench.move({0, 0, -0.05}, 0.15);
  EXPECT_EQ(bench.world->body(bench.index_of("tray")).group_kind, api::GroupKind::kMerged);
  EXPECT_EQ(bench.world->body(bench.index_of("other")).group_kind, api::GroupKind::kDormant);
  bench.grip(0);
  EXPECT_TRUE(bench.world->gripper(0).holding);
  bench.move({0, 0, 0.05}, 0.2);
  bench.run(200);
  EXPECT_EQ(bench.world->body(bench.index_of("tray")).group_kind, api::GroupKind::kDormant);
  EXPECT_EQ(bench.world->body(bench.index_of("g1")).group_kind, api::GroupKind::kNone);
}

// ---- faults

/// A tray of four on the table, and beside it a gear that lies deep in something.
class Landing : public testing::TestWithParam<Simplification> {
 protected:
  /// The gear lands on the table; then a plate that stands out of it is there too. The step after.
  void land(double gap_m, double plate_m) {
    auto scene = tray_of_four(GetParam());
    Pose above;
    above.p = {0.08 + gap_m + gear_type("d60").disc_radius_m, 0, 0.01};
    add_gear(scene, "falling", "d60", above);
    bench.emplace(scene);
    bench->run(150);
    ASSERT_EQ(bench->world->penetration_faults(), 0u);
    ASSERT_EQ(alone(), 0);
    const auto before = bench->world->save();
    Pose centre;
    constexpr double kThick = 0.05;
    centre.p = {above.p.x(), 0, plate_m - 0.5 * kThick};
    scene.fixed.push_back({"plate", {0.05, 0.05, kThick}, centre});
    bench.emplace(std::move(scene));
    bench->world->restore(before);
    bench->world->set_velocity(bench->index_of("falling"), {0, 0, 1e-4}, {0, 0, 0});
    bench->run(1);
  }
  /// How many of the tray and its gears are neither merged nor asleep.
  [[nodiscard]] int alone() const {
    int count = 0;
    for (const char* name : {"tray", "g1", "g2", "g3", "g4"}) {
      if (bench->world->body(bench->index_of(name)).group_kind == api::GroupKind::kNone) ++count;
    }
    return count;
  }
  std::optional<Bench> bench;
};

TEST_P(Landing, AFaultBreaksUpTheGroupNextToIt) {
  land(1e-3, 0.6e-3);
  EXPECT_GT(bench->world->penetration_faults(), 0u);
  EXPECT_EQ(alone(), 5);
  bench->run(400);
  EXPECT_EQ(alone(), 0) << "at rest again";
}

TEST_P(Landing, AFaultFurtherOffDoesNot) {
  land(4e-3, 0.6e-3);
  EXPECT_GT(bench->world->penetration_faults(), 0u);
  EXPECT_EQ(alone(), 0);
}

TEST_P(Landing, WithoutAFaultItStaysTogether) {
  land(1e-3, 0.4e-3);
  EXPECT_EQ(bench->world->penetration_faults(), 0u);
  EXPECT_EQ(alone(), 0);
}

INSTANTIATE_TEST_SUITE_P(Simplification, Landing,
                         testing::Values(Simplification::kMerge, Simplification::kDormant));

}  // namespace
}  // namespace aprsim::physics::test
