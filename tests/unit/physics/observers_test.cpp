// A merged or dormant group is indistinguishable to those who look.

#include <gtest/gtest.h>

#include "tests/unit/physics/cell_builder.hpp"

namespace aprsim::physics::test {
namespace {

using scene::Simplification;

scene::Scene loaded_belt(Simplification mode) {
  auto scene = empty_scene();
  scene.physics.simplification = mode;
  add_belt(scene);
  add_tray(scene, "a", "small4", {-1.0, 0.1}, {"s1=a1", "s2=a2", "s3=a3", "s4=a4"}, 0.2);
  add_tray(scene, "b", "medium4", {-0.7, -0.1}, {"s1=b1", "s4=b4"}, -0.4);
  return scene;
}

class Observers : public testing::TestWithParam<Simplification> {};

// A run of the belt with start, change of direction and stop: poses, velocities, contacts and what
// is called resting are those of contacts solved in full.
TEST_P(Observers, SeeTheSameOverARunOfTheBelt) {
  Bench full(loaded_belt(Simplification::kOff));
  Bench bench(loaded_belt(GetParam()));
  double speed = 0;
  for (int step = 0; step < 2600; ++step) {
    const double wanted = step < 300 ? 0 : step < 1300 ? 0.2 : step < 2000 ? -0.1 : 0;
    speed += std::clamp(wanted - speed, -5e-4, 5e-4);
    for (Bench* each : {&full, &bench}) {
      each->world->set_belt_speed(speed);
      each->run(1);
    }
    if (step < 100) continue;  // settling
    ASSERT_EQ(bench.world->contact_count(), full.world->contact_count()) << step;
    for (int i = 0; i < full.world->body_count(); ++i) {
      const BodyState one = full.world->body(i), other = bench.world->body(i);
      ASSERT_LT((one.p_WB - other.p_WB).norm(), 1e-6) << "body " << i << " at step " << step;
      ASSERT_LT(one.q_WB.angularDistance(other.q_WB), 5e-5) << "body " << i << " at " << step;
      ASSERT_LT((one.v_W - other.v_W).norm(), 1e-5) << "body " << i << " at step " << step;
      ASSERT_EQ(one.resting, other.resting) << "body " << i << " at step " << step;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Simplification, Observers,
                         testing::Values(Simplification::kMerge, Simplification::kDormant));

}  // namespace
}  // namespace aprsim::physics::test
