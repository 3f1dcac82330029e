// A world that goes on from a saved state goes on bit for bit, whichever mode simplifies contacts.

#include <algorithm>
#include <stdexcept>

#include <gtest/gtest.h>

#include "tests/support/parameter_names.hpp"
#include "tests/unit/world/physics/cell_builder.hpp"

namespace aprsim::physics::test {
namespace {

using scene::Simplification;

/// Two trays on a belt, a loose gear, a hand over a gear.
scene::Scene cell(Simplification mode) {
  auto scene = empty_scene();
  scene.physics.simplification = mode;
  add_belt(scene);
  add_busy_bodies(scene);
  return scene;
}

/// Picks the gear, then lifts it and starts the belt; 900 steps in all.
void act(Bench& bench, int step) {
  constexpr double kDown = 0.05 / 150;
  Eigen::Isometry3d X_WT = bench.X_WT;
  if (step < 150) X_WT.translation().z() -= kDown;
  if (step == 160) bench.world->set_gripper(0, 0);
  if (step >= 400 && step < 550) X_WT.translation().z() += kDown;
  if (step >= 450) bench.world->set_belt_speed(5e-4 * std::min(step - 450, 200));
  if (step == 700) bench.world->set_gripper(0, 1);
  bench.step_tool(X_WT);
}

class Save : public testing::TestWithParam<std::tuple<Simplification, int>> {};

TEST_P(Save, GoesOnBitForBit) {
  const auto [mode, at] = GetParam();
  constexpr int kSettle = 120, kSteps = 900;
  Bench first(cell(mode));
  first.run(kSettle);
  for (int step = 0; step < at; ++step) act(first, step);
  const PhysicsWorld::State state = first.world->save();
  const Eigen::Isometry3d X_WT = first.X_WT;
  std::vector<std::uint64_t> expected;
  for (int step = at; step < kSteps; ++step) {
    act(first, step);
    expected.push_back(first.world->state_hash());
  }
  Bench fresh(cell(mode));
  for (Bench* bench : {&first, &fresh}) {  // the same world, and one built anew
    bench->world->restore(state);
    bench->X_WT = X_WT;
    for (int step = at; step < kSteps; ++step) {
      act(*bench, step);
      ASSERT_EQ(bench->world->state_hash(), expected[static_cast<std::size_t>(step - at)])
          << step - at << " steps on, in the " << (bench == &first ? "same" : "fresh") << " world";
    }
  }
}

// Before anything touches, while the fingers close, while the gear leaves its pocket, in the air
// with the belt starting.
INSTANTIATE_TEST_SUITE_P(
    Modes, Save,
    testing::Combine(testing::Values(Simplification::kOff, Simplification::kVirtualJoints,
                                     Simplification::kMerge, Simplification::kDormant),
                     testing::Values(100, 175, 190, 430, 520)));

class SaveIdle : public testing::TestWithParam<std::tuple<Simplification, double>> {};

// A gripper at rest in the air is not computed until something touches it. In a world built anew
// from the state before that touch, too: pegs press the fingers from below, then a tray on the
// belt runs into them.
TEST_P(SaveIdle, TouchedGripperGoesOnBitForBitInAFreshWorld) {
  const auto [mode, setting] = GetParam();
  constexpr int kSteps = 700;
  Bench first(cell(mode));
  first.run(100);
  first.grip(1 - setting);
  first.grip(setting);
  first.run(300);
  ASSERT_EQ(first.world->gripper(0).palm_deflection_m, 0) << "idle: exactly at rest";
  const PhysicsWorld::State state = first.world->save();
  Bench fresh(cell(mode));
  fresh.world->restore(state);
  fresh.X_WT = first.X_WT;
  ASSERT_EQ(fresh.world->state_hash(), first.world->state_hash());
  int touched = 0;
  for (int step = 0; step < kSteps; ++step) {
    for (Bench* bench : {&first, &fresh}) {
      Eigen::Isometry3d X_WT = bench->X_WT;
      if (step < 240) X_WT.translation().z() -= 0.06 / 240;
      bench->world->set_belt_speed(2e-4 * std::clamp(step - 300, 0, 200));
      bench->step_tool(X_WT);
    }
    if (first.world->gripper(0).palm_deflection_m > 1e-6) ++touched;
    ASSERT_EQ(fresh.world->state_hash(), first.world->state_hash()) << step << " steps on";
  }
  EXPECT_GT(touched, 10);
}

// Closed fingers come down on a peg, open ones on the gear about it.
INSTANTIATE_TEST_SUITE_P(Modes, SaveIdle,
                         testing::Combine(testing::Values(Simplification::kOff,
                                                          Simplification::kDormant),
                                          testing::Values(0.0, 1.0)));

TEST(SaveChecks, AStateOfAnotherSceneIsRefused) {
  Bench small(cell(Simplification::kOff));
  auto other = cell(Simplification::kOff);
  add_gear(other, "extra", "small", {{1, 0, 0.1}, Eigen::Quaterniond::Identity()});
  Bench large(std::move(other));
  EXPECT_THROW(large.world->restore(small.world->save()), std::invalid_argument);
  EXPECT_THROW(large.world->restore(PhysicsWorld::State()), std::invalid_argument);
}

}  // namespace
}  // namespace aprsim::physics::test
