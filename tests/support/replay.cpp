#include "tests/support/replay.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace aprsim::test {

Trace record_demo(const std::shared_ptr<const scene::Scene>& scene, double seconds) {
  world::World world(scene, 1);
  KittingDemo demo(world);
  Trace trace;
  const auto steps = static_cast<int>(std::lround(seconds / scene->physics.step_s));
  for (int step = 1; step <= steps; ++step) {
    demo.advance();
    if (step % kHashPeriod != 0) continue;
    trace.hashes.push_back(world.state_hash());
    trace.trips.push_back(demo.trips());
  }
  trace.commands = demo.commands();
  return trace;
}

Trace replay_demo(const std::shared_ptr<const scene::Scene>& scene, const Trace& trace) {
  std::optional<world::World> world(std::in_place, scene, 1);
  Trace again;
  std::size_t next = 0;
  const int steps = kHashPeriod * static_cast<int>(trace.hashes.size());
  for (int step = 1; step <= steps; ++step) {
    if (step == steps / 2) {
      const world::WorldState saved = world->save();
      world.emplace(scene, 2);
      world->restore(saved);
    }
    while (next < trace.commands.size() && trace.commands[next].step == world->step_count()) {
      apply(*world, trace.commands[next]);
      again.commands.push_back(trace.commands[next++]);
    }
    world->step();
    if (step % kHashPeriod == 0) again.hashes.push_back(world->state_hash());
  }
  return again;
}

int count_mismatches(const Trace& a, const Trace& b) {
  const std::size_t common = std::min(a.hashes.size(), b.hashes.size());
  auto count = static_cast<int>(std::max(a.hashes.size(), b.hashes.size()) - common);
  for (std::size_t i = 0; i < common; ++i) count += a.hashes[i] != b.hashes[i] ? 1 : 0;
  return count;
}

}  // namespace aprsim::test
