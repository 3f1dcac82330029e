// Lifting limits of a vacuum cup: contact and friction under the suction force.

#include "world/physics/contacts/suction_search.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/unit/world/physics/cell_builder.hpp"

namespace aprsim::physics::test {
namespace {

using Eigen::Vector3d;

constexpr double kG = 9.81, kGearKg = 0.0102, kTrayKg = 0.2;
constexpr double kPegTop = 0.015 + 0.026;  // of a small gear in its tray, over the table
constexpr double kAbove = 0.02;

/// A cup over `place`, its vacuum such that it draws with `force_n` when its lip is covered.
scene::Scene cup_scene(const Vector3d& place, double radius_m, double force_n) {
  auto scene = empty_scene();
  add_table(scene);
  add_tray(scene, "tray", "small4", {0, 0}, {"s1=g"});
  auto& gripper = add_hand(scene, place + Vector3d(0, 0, kAbove)).gripper;
  gripper.law = scene::GripperLaw::kConstant;
  gripper.gap_open_m = gripper.gap_closed_m = 0;
  gripper.palm_stiffness_n_m = 1000;
  gripper.palm_damping_ns_m = 60;
  gripper.pad_friction = 0.6;
  gripper.cup =
      scene::VacuumCup{.radius_m = radius_m,
                       .max_vacuum_pa = force_n / (std::numbers::pi * radius_m * radius_m),
                       .free_flow_m3_s = 1.67e-4,
                       .evacuation_s = 0.02,
                       .lip_compliance_m = 5e-4,
                       .roughness_m = 0};
  return scene;
}

const Vector3d kPeg(-0.045, 0.045, kPegTop), kTrayTop(0, 0, 0.015);
constexpr double kSmall = 0.003, kWide = 0.02;

/// Down onto what is there, 0.3 mm into the mount's spring, and the ejector on.
void draw(Bench& bench) {
  bench.run(20);
  bench.move({0, 0, -kAbove - 3e-4}, 0.3);
  bench.world->set_gripper(0, 0);
  bench.run(250);
}

[[nodiscard]] bool holds(const Bench& bench, const std::string& body) {
  return bench.world->gripper(0).holding &&
         bench.world->gripper(0).held_body == bench.index_of(body);
}

/// For 100 ms from rest.
void accelerate(Bench& bench, const Vector3d& accel) {
  const Eigen::Isometry3d start = bench.X_WT;
  for (int i = 1; i <= 100; ++i) {
    Eigen::Isometry3d next = start;
    const double t = i * 1e-3;
    next.translation() += 0.5 * t * t * accel;
    bench.step_tool(next);
  }
}

void tilt(Bench& bench, double angle) {
  const Eigen::Isometry3d start = bench.X_WT;
  for (int i = 1; i <= 1000; ++i) {
    Eigen::Isometry3d next = start;
    next.linear() =
        Eigen::AngleAxisd(angle * i / 1000, Vector3d::UnitX()).toRotationMatrix() * start.linear();
    bench.step_tool(next);
  }
  bench.run(200);
}

TEST(VacuumCup, LiftsAGearByTheTopOfItsPeg) {
  Bench bench(cup_scene(kPeg, kSmall, 1.7));
  draw(bench);
  EXPECT_NEAR(bench.world->gripper(0).vacuum_pa, 1.7 / (std::numbers::pi * 9e-6), 100);
  EXPECT_NEAR(bench.world->gripper(0).force_n[0], 1.7, 0.01);
  EXPECT_TRUE(bench.world->gripper(0).settled);
  ASSERT_TRUE(holds(bench, "g"));
  const double before = bench.X_WB("g").translation().z();
  bench.move({0, 0, 0.1}, 0.5);
  bench.run(300);
  EXPECT_NEAR(bench.X_WB("g").translation().z(), before + 0.1, 1e-3);
  ASSERT_TRUE(holds(bench, "g"));
  // The arm bears the gear's weight and nothing else.
  Vector3d load = Vector3d::Zero();
  for (const ArmForce& force : bench.world->arm_forces(0)) {
    if (force.on_gripper && !force.relayed) load += force.f_W;
  }
  EXPECT_NEAR(load.z(), -kGearKg * kG, 2e-3);
  EXPECT_EQ(bench.world->penetration_faults(), 0u);
  // Without vacuum it falls.
  bench.world->set_gripper(0, 1);
  bench.run(300);
  EXPECT_FALSE(bench.world->gripper(0).holding);
  EXPECT_LT(bench.X_WB("g").translation().z(), before + 0.06);
}

TEST(VacuumCup, HalfCoveredItLiftsNothing) {
  Bench bench(cup_scene(kPeg + Vector3d(0.0038, 0, 0), kSmall, 1.7));
  const double before = bench.X_WB("g").translation().z();
  draw(bench);
  EXPECT_FALSE(bench.world->gripper(0).holding);
  EXPECT_LT(bench.world->gripper(0).vacuum_pa, 5e3);
  bench.move({0, 0, 0.1}, 0.5);
  EXPECT_NEAR(bench.X_WB("g").translation().z(), before, 1e-3);
}

TEST(VacuumCup, TiltedBeyondItsLipItLiftsNothing) {
  auto scene = cup_scene(kPeg, kSmall, 1.7);
  Bench bench(std::move(scene));
  const double before = bench.X_WB("g").translation().z();
  bench.run(20);
  tilt(bench, 12 * std::numbers::pi / 180);
  bench.move({0, 0, -kAbove}, 0.3);
  bench.world->set_gripper(0, 0);
  bench.run(250);
  EXPECT_LT(bench.world->gripper(0).vacuum_pa, 5e3);
  bench.move({0, 0, 0.1}, 0.5);
  EXPECT_NEAR(bench.X_WB("g").translation().z(), before, 1e-3);
}

// Drawn with twice its weight it follows upwards with less than g.
TEST(VacuumCup, LosesWhatIsAcceleratedBeyondItsForce) {
  for (const bool beyond : {false, true}) {
    Bench bench(cup_scene(kPeg, kSmall, 2 * kGearKg * kG));
    draw(bench);
    bench.move({0, 0, 0.1}, 0.8);
    bench.run(100);
    ASSERT_TRUE(holds(bench, "g"));
    accelerate(bench, {0, 0, beyond ? 1.4 * kG : 0.7 * kG});
    EXPECT_EQ(holds(bench, "g"), !beyond);
    if (!beyond) continue;
    bench.run(300);
    EXPECT_LT(bench.X_WB("g").translation().z(), 0.1) << "it has fallen";
  }
}

// Along the lip friction bears mu (F - m g): 0.6 g here.
TEST(VacuumCup, SlipsAlongItsLipBeyondFriction) {
  for (const bool beyond : {false, true}) {
    auto scene = cup_scene(kTrayTop, kWide, 2 * (kTrayKg + kGearKg) * kG);
    Bench bench(std::move(scene));
    draw(bench);
    bench.move({0, 0, 0.1}, 0.8);
    bench.run(100);
    ASSERT_TRUE(holds(bench, "tray"));
    const Vector3d before = bench.X_TB("tray").translation();
    accelerate(bench, {beyond ? 1.0 * kG : 0.3 * kG, 0, 0});
    const double slip = (bench.X_TB("tray").translation() - before).norm();
    if (beyond) {
      EXPECT_GT(slip, 3e-3);
    } else {
      EXPECT_LT(slip, 3e-4);
    }
  }
}

// The moment of the gear's weight about the lip's rim, with its centre of mass some 25 mm under a
// lip of 3 mm, peels it off at 8 degrees or so.
TEST(VacuumCup, PeelsOffWhenTilted) {
  for (const bool beyond : {false, true}) {
    Bench bench(cup_scene(kPeg, kSmall, 2 * kGearKg * kG));
    draw(bench);
    bench.move({0, 0, 0.15}, 0.8);
    bench.run(100);
    ASSERT_TRUE(holds(bench, "g"));
    tilt(bench, (beyond ? 25 : 3) * std::numbers::pi / 180);
    EXPECT_EQ(holds(bench, "g"), !beyond);
  }
}

TEST(VacuumCup, DrawsItselfOntoATableAndNothingElse) {
  auto scene = cup_scene({0.5, 0.5, 0}, kWide, 30);
  Bench bench(std::move(scene));
  draw(bench);
  EXPECT_GT(bench.world->gripper(0).vacuum_pa, 0.9 * 30 / (std::numbers::pi * kWide * kWide));
  EXPECT_FALSE(bench.world->gripper(0).holding) << "nothing that moves";
  EXPECT_EQ(bench.world->gripper(0).held_body, -1);
}

TEST(VacuumCup, SavedStatesGoOnBitForBit) {
  Bench first(cup_scene(kPeg, kSmall, 1.7));
  draw(first);
  first.move({0, 0, 0.05}, 0.2);
  const PhysicsWorld::State state = first.world->save();
  const Eigen::Isometry3d X_WT = first.X_WT;
  first.move({0.05, 0, 0.05}, 0.3);
  const std::uint64_t expected = first.world->state_hash();
  Bench fresh(cup_scene(kPeg, kSmall, 1.7));
  fresh.world->restore(state);
  fresh.X_WT = X_WT;
  fresh.move({0.05, 0, 0.05}, 0.3);
  EXPECT_EQ(fresh.world->state_hash(), expected);
  EXPECT_EQ(fresh.world->gripper(0).vacuum_pa, first.world->gripper(0).vacuum_pa);
}

TEST(VacuumCup, LeftByItsRobotItLosesWhatItHeld) {
  Bench bench(cup_scene(kPeg, kSmall, 1.7));
  draw(bench);
  bench.move({0, 0, 0.2}, 0.5);
  ASSERT_TRUE(holds(bench, "g"));
  bench.world->detach_tool(0);
  EXPECT_EQ(bench.world->gripper(0).vacuum_pa, 0);
  bench.run(2000);
  EXPECT_LT(bench.world->tool(0).p_WB.z(), 0.1);
  EXPECT_LT(bench.X_WB("g").translation().z(), 0.1);
}

}  // namespace
}  // namespace aprsim::physics::test
