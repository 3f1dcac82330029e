#pragma once

#include <cstdint>
#include <vector>

#include "world/base/time.hpp"

namespace aprsim::api {

/// One object as the overhead camera of a robot sees it, in that robot's vision frame V.
struct VisionDetection {
  int body = -1;            ///< index into CellDescription::bodies
  double x_m = 0, y_m = 0;  ///< of the object's origin
  double rotation_rad = 0;  ///< of its x axis about V's z, in (-pi, pi]
  double score = 0;         ///< share of the object's top that the camera sees, 0..1

  bool operator==(const VisionDetection&) const = default;

  /// See world/archive/archive.hpp.
  template <typename In>
  void require_valid(In& in) const {
    in.index_or_none(In::kPart, body);
  }
};

/// The detections of one camera at one instant.
struct VisionFrame {
  std::uint64_t number = 0;  ///< counts from 1 since reset
  SimTime time{};            ///< of exposure; the frame comes out a latency later
  std::vector<VisionDetection> detections;
};

}  // namespace aprsim::api
