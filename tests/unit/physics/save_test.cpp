// A world that goes on from a saved state goes on bit for bit, whichever mode simplifies contacts.

#include <stdexcept>

#include <gtest/gtest.h>

#include "tests/unit/physics/cell_builder.hpp"

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
