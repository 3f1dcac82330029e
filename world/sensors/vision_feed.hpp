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

/// One camera in simulated time: an exposure each period, whose frame comes out a latency later.
/// The exposure at step 0 is out at once, as of a camera that has run for a while. Frame n of a
/// seed is the same whenever the cell is. No call but the constructor and set_faults() allocates
/// while nothing is wrong. Thread: sim.
class VisionFeed {
 public:
  /// Period and latency are rounded to whole steps.
  VisionFeed(const scene::Vision& vision, const Eigen::Isometry3d& X_WR, SimTime step_size,
             std::uint64_t seed, std::size_t body_count);

  /// True if there is an exposure at this step, which then has to be made.
  [[nodiscard]] bool due(std::uint64_t step) const { return step % period_steps_ == 0; }
  void expose(std::uint64_t step, std::span<const scene::FreeBody> bodies,
              std::span<const Eigen::Isometry3d> X_WP, std::span<const Occluder> occluders);
  /// From the next exposure on; null = nothing is wrong.
  void set_faults(std::shared_ptr<const CameraFaults> faults);
  /// Gives out what has become old enough. Once a step, after any exposure.
  void advance(std::uint64_t step);

  /// Bodies have other numbers now; each old one's new one.
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
  std::vector<api::VisionDetection> frozen_;  ///< what a frozen camera shows
};

}  // namespace aprsim::sensors
