#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "world/scene/model/free_body.hpp"
#include "world/scene/model/scene.hpp"
#include "world/sensors/line_of_sight.hpp"
#include "world/sensors/vision_feed.hpp"

namespace aprsim::sensors {

/// The cameras of the cell, one for each robot. Thread: sim.
class CellVision {
 public:
  CellVision(const scene::Scene& scene, SimTime step_size, std::uint64_t seed,
             std::size_t body_count);

  /// True if some camera exposes at this step; advance() then needs the occluders at its end.
  [[nodiscard]] bool due(std::uint64_t step) const;
  /// Once a step; also once before the first, with step 0. Poses as `bodies` are numbered.
  void advance(std::uint64_t step, std::span<const scene::FreeBody> bodies,
               std::span<const Eigen::Isometry3d> X_WP, std::span<const Occluder> occluders);

  /// The same for the steps from `first` to `last` of a cell that is at rest.
  void advance_still(std::uint64_t first, std::uint64_t last,
                     std::span<const scene::FreeBody> bodies,
                     std::span<const Eigen::Isometry3d> X_WP, std::span<const Occluder> occluders);
  /// Whether some camera exposes at one of these steps.
  [[nodiscard]] bool due(std::uint64_t first, std::uint64_t last) const;

  /// See VisionFeed.
  void set_faults(std::size_t robot, std::shared_ptr<const CameraFaults> faults) {
    feeds_[robot].set_faults(std::move(faults));
  }

  /// Renumbers bodies: `new_of` has the new number of each old one.
  void renumber(std::span<const int> new_of) {
    for (auto& feed : feeds_) feed.renumber(new_of);
  }

  [[nodiscard]] const api::VisionFrame& latest(std::size_t robot) const {
    return feeds_[robot].latest();
  }

  static constexpr bool kAsMany = true;  ///< as the scene has
  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [feeds] = self;
    io(feeds);
  }

 private:
  std::vector<VisionFeed> feeds_;
};

}  // namespace aprsim::sensors
