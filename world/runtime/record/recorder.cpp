#include "world/runtime/record/recorder.hpp"

#include "world/cell/world.hpp"

namespace aprsim::world {

StateSample sample_of(const World& world) {
  api::Snapshot now;
  world.write(now);
  StateSample sample;
  sample.hash = world.state_hash();
  for (std::size_t i = 0; i < now.robots.size(); ++i) {
    for (std::size_t j = 0; j < now.cell->robots[i].joints.size(); ++j) {
      sample.joints_rad.push_back(now.robots[i].joints[j].position_rad);
    }
  }
  for (const api::BodySnapshot& body : now.bodies) {
    for (const double coordinate : body.X_WB.p) sample.bodies_m.push_back(coordinate);
  }
  sample.belt_travel_m = now.conveyor.travel_m;
  return sample;
}

}  // namespace aprsim::world
