// A body that falls where nothing can catch it is lost, without an effect on the others.

#include <gtest/gtest.h>

#include "tests/support/parameter_names.hpp"
#include "tests/unit/world/physics/cell_builder.hpp"

namespace aprsim::physics::test {
namespace {

using scene::Simplification;

constexpr int kLongAfter = 8000;  // steps: a free fall would have got to 78 m/s

/// A tray with gears and a loose gear beside a table, in the air; another tray stands on it.
scene::Scene over_the_edge(Simplification mode) {
  auto scene = empty_scene();
  scene.physics.simplification = mode;
  add_table(scene);
  add_tray(scene, "stays", "small4", {0, 0}, {"s1=g1", "s2=g2"});
  add_tray(scene, "falls", "medium4", {2, 0}, {"s1=f1", "s4=f2"});
  Pose loose;
  loose.p = {-1.5, 0, 0.3};
  add_gear(scene, "loose", "small", loose);
  return scene;
}

class Lost : public testing::TestWithParam<Simplification> {};

TEST_P(Lost, FallWithoutAFloorStopsNothing) {
  Bench bench(over_the_edge(GetParam()));
  bench.run(200);
  for (int i = 0; i < bench.world->body_count(); ++i) EXPECT_FALSE(bench.world->body(i).lost_step);
  bench.run(kLongAfter);
  for (const char* name : {"falls", "f1", "f2", "loose"}) {
    const BodyState state = bench.world->body(bench.index_of(name));
    ASSERT_TRUE(state.lost_step) << name;
    EXPECT_GT(*state.lost_step, 500u);
    EXPECT_LT(*state.lost_step, 1000u);
    EXPECT_EQ(state.v_W.norm(), 0);
    EXPECT_FALSE(state.resting);
    EXPECT_EQ(state.group, -1) << name;
  }
  for (const char* name : {"stays", "g1", "g2"}) {
    EXPECT_FALSE(bench.world->body(bench.index_of(name)).lost_step) << name;
    EXPECT_TRUE(bench.world->body(bench.index_of(name)).resting) << name;
  }
}

// The others rest as in a world in which nothing falls; only the order of the solver's rows is
// another one.
TEST_P(Lost, TheOthersGoOnAsIfItHadNotBeenThere) {
  auto without = empty_scene();
  without.physics.simplification = GetParam();
  add_table(without);
  add_tray(without, "stays", "small4", {0, 0}, {"s1=g1", "s2=g2"});
  Bench bench(over_the_edge(GetParam())), alone(std::move(without));
  bench.run(2000);
  alone.run(2000);
  for (const char* name : {"stays", "g1", "g2"}) {
    EXPECT_LT((bench.X_WB(name).matrix() - alone.X_WB(name).matrix()).norm(), 2e-6) << name;
  }
}

TEST_P(Lost, SavedStatesKeepIt) {
  Bench first(over_the_edge(GetParam()));
  first.run(300);
  const auto falling = first.world->save();
  first.run(2000);
  const auto lost = first.world->save();
  const auto expected = first.world->body(first.index_of("loose"));
  ASSERT_TRUE(expected.lost_step);
  first.run(500);
  const std::uint64_t hash = first.world->state_hash();
  Bench fresh(over_the_edge(GetParam()));
  for (Bench* bench : {&first, &fresh}) {
    // Back to where it still fell: it is there again, and is lost in the same step.
    bench->world->restore(falling);
    EXPECT_FALSE(bench->world->body(bench->index_of("loose")).lost_step);
    bench->run(2000);
    EXPECT_EQ(bench->world->body(bench->index_of("loose")).lost_step, expected.lost_step);
    bench->run(500);
    EXPECT_EQ(bench->world->state_hash(), hash);
    bench->world->restore(lost);
    EXPECT_EQ(bench->world->body(bench->index_of("loose")).lost_step, expected.lost_step);
    EXPECT_EQ(bench->X_WB("loose").translation(), expected.p_WB);
    bench->run(500);
    EXPECT_EQ(bench->world->state_hash(), hash);
  }
  const Bench again(over_the_edge(GetParam()));
  EXPECT_FALSE(again.world->body(again.index_of("loose")).lost_step);
}

// Falling far onto something is not being lost.
TEST_P(Lost, AFallOntoTheTableIsNone) {
  auto scene = empty_scene();
  scene.physics.simplification = GetParam();
  add_table(scene);
  Pose high;
  high.p.z() = 4;
  add_gear(scene, "g", "small", high);
  Bench bench(std::move(scene));
  bench.run(3000);
  EXPECT_FALSE(bench.world->body(0).lost_step);
  EXPECT_GT(bench.X_WB("g").translation().z(), 0);
}

INSTANTIATE_TEST_SUITE_P(Modes, Lost,
                         testing::Values(Simplification::kOff, Simplification::kVirtualJoints,
                                         Simplification::kMerge, Simplification::kDormant));

}  // namespace
}  // namespace aprsim::physics::test
