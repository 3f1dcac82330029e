#include "world/runtime/record/recorder.hpp"

#include "world/cell/world.hpp"

namespace aprsim::world {

StateSample sample_of(const World& world) {
  StateSample sample;
  sample.hash = world.state_hash();
  for (const SimulatedRobot& robot : world.robots()) {
    sample.joints_rad.insert(sample.joints_rad.end(), robot.q().begin(), robot.q().end());
  }
  const physics::PhysicsWorld& physics = world.physics();
  for (int i = 0; i < physics.body_count(); ++i) {
    for (const double coordinate : physics.body(i).p_WB) sample.bodies_m.push_back(coordinate);
  }
  if (world.conveyor() != nullptr) sample.belt_travel_m = world.conveyor()->readings().travel_m;
  return sample;
}

}  // namespace aprsim::world
