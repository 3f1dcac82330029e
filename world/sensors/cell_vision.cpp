#include "world/sensors/cell_vision.hpp"

#include <algorithm>

#include "world/sensors/random.hpp"

namespace aprsim::sensors {

CellVision::CellVision(const scene::Scene& scene, SimTime step_size, std::uint64_t seed,
                       std::size_t body_count) {
  for (std::size_t i = 0; i < scene.robots.size(); ++i) {
    const scene::Robot& robot = scene.robots[i];
    feeds_.emplace_back(robot.vision, robot.X_WB.isometry() * robot.X_BR.isometry(), step_size,
                        mix_seed(seed, i), body_count);
  }
}

bool CellVision::due(std::uint64_t step) const { return due(step, step); }

bool CellVision::due(std::uint64_t first, std::uint64_t last) const {
  return std::ranges::any_of(feeds_,
                             [=](const VisionFeed& feed) { return feed.first_due(first) <= last; });
}

void CellVision::advance_still(std::uint64_t first, std::uint64_t last,
                               std::span<const scene::FreeBody> bodies,
                               std::span<const Eigen::Isometry3d> X_WP,
                               std::span<const Occluder> occluders) {
  for (auto& feed : feeds_) feed.advance_still(first, last, bodies, X_WP, occluders);
}

void CellVision::advance(std::uint64_t step, std::span<const scene::FreeBody> bodies,
                         std::span<const Eigen::Isometry3d> X_WP,
                         std::span<const Occluder> occluders) {
  for (auto& feed : feeds_) {
    if (feed.due(step)) feed.expose(step, bodies, X_WP, occluders);
    feed.advance(step);
  }
}

}  // namespace aprsim::sensors
