#pragma once

#include <cstddef>
#include <string>

#include "world/api/values/pose.hpp"
#include "world/scene/model/lens.hpp"

namespace aprsim::scene {

inline constexpr std::size_t kMaxCameras = 8;

/// A camera whose pictures are rendered. It detects nothing: see Vision for the text lines.
struct Camera {
  std::string name;
  int robot = -1;  ///< that it serves: index into Scene::robots; -1 = none
  Pose X_WC;       ///< camera frame in world, see Lens
  Lens lens;
  double rate_hz = 10;
  double latency_s = 0;  ///< from exposure until the picture is out
  int jpeg_quality = 80;
  double exposure = 1;   ///< factor on the brightness
  double noise = 0;      ///< standard deviation in each colour [1/255]
  double blur_px = 0.5;  ///< standard deviation of a point's picture
};

}  // namespace aprsim::scene
