#include "world/cell/cell_vision.hpp"

#include <algorithm>

#include "world/sensors/random.hpp"

namespace aprsim::world {

CellVision::CellVision(const scene::Scene& scene, SimTime step_size, std::uint64_t seed,
                       std::size_t body_count) {
  for (std::size_t i = 0; i < scene.robots.size(); ++i) {
    const scene::Robot& robot = scene.robots[i];
    feeds_.emplace_back(robot.vision, robot.X_WB.isometry() * robot.X_BR.isometry(), step_size,
                        sensors::mix_seed(seed, i), body_count);
  }
}

bool CellVision::due(std::uint64_t step) const {
  return std::any_of(feeds_.begin(), feeds_.end(),
                     [step](const sensors::VisionFeed& feed) { return feed.due(step); });
}

void CellVision::look(std::uint64_t step, const api::CellDescription& cell,
                      const SensorOccluders& occluders) {
  for (auto& feed : feeds_) {
    if (feed.due(step)) feed.expose(step, cell, occluders.X_WP(), occluders.all());
    feed.advance(step);
  }
}

}  // namespace aprsim::world
