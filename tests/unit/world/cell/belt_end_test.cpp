#include <algorithm>
#include <memory>

#include <gtest/gtest.h>

#include "tests/support/cell_script.hpp"
#include "world/cell/world.hpp"

namespace aprsim::world {
namespace {

// The belt runs until trays and gears fall off its end, 0.9 m down, onto each other: however they
// land and get stuck, nothing gets faster than a fall and the spin it can turn into.
TEST(BeltEnd, PartsFallIntoAHeap) {
  const auto scene = std::make_shared<scene::Scene>(*test::load_scene("aprs"));
  World world(scene, 1);
  world.apply(1, api::ConveyorCommand{.run = true, .forward = false, .speed_m_s = 0.15});
  api::Snapshot snapshot;
  double fastest = 0;
  int fallen = 0;
  for (int step = 0; step < 14000; ++step) {
    world.step();
    if (step % 5 != 0) continue;
    world.write(snapshot);
    fallen = 0;
    for (const auto& body : snapshot.bodies) {
      fastest =
          std::max(fastest, body.v_W.norm() + 0.0125 * body.omega_W.norm());  // at a small rim
      fallen += body.X_WB.p.z() < 0.3;
    }
  }
  EXPECT_GT(fallen, 4);
  EXPECT_LT(fastest, 9);
}

}  // namespace
}  // namespace aprsim::world
