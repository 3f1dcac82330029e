#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "world/api/snapshot/vision.hpp"
#include "world/scene/model/free_body.hpp"

namespace aprsim::sensors {

/// Effects of injected faults on one camera's frames. Bodies are indices as in the cell.
struct CameraFaults {
  bool outage = false;  ///< no frame comes out
  bool frozen = false;  ///< all frames have the detections of the last one
  double late_s = 0;    ///< besides the latency
  double bias_x_m = 0, bias_y_m = 0, bias_yaw_rad = 0;
  double scale = 1;      ///< of x and y
  double flip_rate = 0;  ///< chance of a kit tray to be reported turned by half, each frame
  std::vector<int> lost;
  std::vector<api::VisionDetection> ghosts;
  std::vector<std::pair<int, int>> swapped;    ///< confused with each other
  std::vector<std::pair<int, double>> scores;  ///< body and factor on its score

  bool operator==(const CameraFaults&) const = default;

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [outage, frozen, late_s, bias_x_m, bias_y_m, bias_yaw_rad, scale, flip_rate, lost, ghosts,
           swapped, scores] = self;
    io(outage, frozen, late_s, bias_x_m, bias_y_m, bias_yaw_rad, scale, flip_rate, lost, ghosts,
       swapped, scores);
  }
  template <typename In>
  void require_valid(In& in) const {
    for (const int body : lost) in.index(In::kPart, body);
    for (const auto& [first, second] : swapped) in.index(In::kPart, first, second);
    for (const auto& [body, factor] : scores) in.index(In::kPart, body);
    in.require(late_s >= 0 && late_s < 3600, "a camera that is late by more than an hour");
  }
};

/// Applies the faults to a camera's detections; `seed` is the frame's.
void spoil(const CameraFaults& faults, std::span<const scene::FreeBody> bodies, std::uint64_t seed,
           std::vector<api::VisionDetection>& detections);

}  // namespace aprsim::sensors
