#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "world/api/snapshot/vision.hpp"
#include "world/scene/model/free_body.hpp"
#include "world/sensors/camera_faults.hpp"
#include "world/sensors/overhead_camera.hpp"

namespace aprsim::sensors {

/// One camera in simulated time: one exposure each period, whose frame is published after a
/// latency. The frame of step 0 is published at once, as by a camera that was running before. Frame
/// n of a seed is the same if the cell is. Without faults, no call but the constructor and
/// set_faults() allocates. Thread: sim.
class VisionFeed {
 public:
  /// Period and latency are rounded to whole steps.
  VisionFeed(const scene::Vision& vision, const Eigen::Isometry3d& X_WR, SimTime step_size,
             std::uint64_t seed, std::size_t body_count);

  /// Whether expose() is due at this step.
  [[nodiscard]] bool due(std::uint64_t step) const { return step % period_steps_ == 0; }
  /// The first such step from this one on.
  [[nodiscard]] std::uint64_t first_due(std::uint64_t step) const {
    return (step + period_steps_ - 1) / period_steps_ * period_steps_;
  }
  void expose(std::uint64_t step, std::span<const scene::FreeBody> bodies,
              std::span<const Eigen::Isometry3d> X_WP, std::span<const Occluder> occluders);
  /// expose() and advance() for the steps from `first` to `last`, while the bodies and occluders
  /// stay as they are. Frames that later ones replace are not made; the state is the same.
  void advance_still(std::uint64_t first, std::uint64_t last,
                     std::span<const scene::FreeBody> bodies,
                     std::span<const Eigen::Isometry3d> X_WP, std::span<const Occluder> occluders);
  /// Sets the faults from the next exposure on; null = none.
  void set_faults(std::shared_ptr<const CameraFaults> faults);
  /// Publishes the frames whose latency is over. Once a step, after any exposure.
  void advance(std::uint64_t step);

  /// Renumbers bodies: `new_of` has the new number of each old one.
  void renumber(std::span<const int> new_of);

  [[nodiscard]] const api::VisionFrame& latest() const { return latest_; }

  static constexpr bool kAsMany = true;  ///< as the scene has
  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [camera, step_size, seed, period_steps, latency_steps, exposures, ring, first, count,
           latest, faults, frozen] = self;
    io(seed, exposures, ring, first, count, latest, faults, frozen);
    io.require(first < ring.size() && count <= ring.size(), "a frame beyond those that wait");
  }
  template <typename In>
  void require_valid(In& in) const {
    in.require(ring_.size() <= 100'000, "more frames than a camera keeps");
  }

 private:
  struct Pending {
    api::VisionFrame frame;
    std::uint64_t out_at = 0;  ///< step

    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [frame, out_at] = self;
      io(frame, out_at);
    }
  };

  OverheadCamera camera_;
  SimTime step_size_;
  std::uint64_t seed_;
  std::uint64_t period_steps_, latency_steps_;
  std::uint64_t exposures_ = 0;
  std::vector<Pending> ring_;
  std::size_t first_ = 0, count_ = 0;  ///< of the ring
  api::VisionFrame latest_;
  std::shared_ptr<const CameraFaults> faults_;
  std::vector<api::VisionDetection> frozen_;  ///< detections of a frozen camera
};

}  // namespace aprsim::sensors
