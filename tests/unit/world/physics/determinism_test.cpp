#include <gtest/gtest.h>

#include "tests/support/allocation_counter.hpp"
#include "tests/unit/world/physics/cell_builder.hpp"

namespace aprsim::physics::test {
namespace {

scene::Scene busy_scene() {
  auto scene = empty_scene();
  add_table(scene);
  add_busy_bodies(scene);
  return scene;
}

std::vector<std::uint64_t> play(Bench& bench) {
  std::vector<std::uint64_t> hashes;
  const auto note = [&] { hashes.push_back(bench.world->state_hash()); };
  bench.run(150);
  note();
  bench.move({0, 0, -0.05}, 0.15);
  bench.grip(0);
  note();
  bench.move({0, 0, 0.05}, 0.15);
  note();
  bench.move({0.3, 0, 0}, 0.3);
  bench.move({0, 0, -0.05}, 0.2);
  note();
  bench.grip(1);
  bench.move({0, 0, 0.05}, 0.15);
  note();
  return hashes;
}

TEST(Determinism, SameSceneAndCallsGiveTheSameBits) {
  Bench first(busy_scene());
  const auto expected = play(first);
  Bench second(busy_scene());
  EXPECT_EQ(play(second), expected);
}

TEST(Determinism, HashSeesASmallDifference) {
  Bench first(busy_scene());
  auto scene = busy_scene();
  scene.gears[0].X_WP.p.x() += 1e-12;
  Bench second(std::move(scene));
  first.run(10);
  second.run(10);
  EXPECT_NE(first.world->state_hash(), second.world->state_hash());
}

TEST(Allocation, NoneInAStepAfterWarmUp) {
  Bench bench(busy_scene());
  bench.run(150);
  bench.move({0, 0, -0.05}, 0.15);
  bench.grip(0);
  bench.move({0, 0, 0.01}, 0.1);
  bench.move({0, 0, -0.01}, 0.1);
  bench.grip(1);  // warm: all solver paths have run
  bench.world->set_gripper(0, 0);
  long worst = 0;
  for (int i = 0; i < 200; ++i) {
    const long before = aprsim::test::allocations();
    bench.world->step();
    worst = std::max(worst, aprsim::test::allocations() - before);
  }
  EXPECT_TRUE(bench.world->gripper(0).holding);
  EXPECT_EQ(worst, 0);
}

}  // namespace
}  // namespace aprsim::physics::test
