#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "world/api/values/pose.hpp"
#include "world/scene/model/lens.hpp"

namespace aprsim::scene {

inline constexpr std::size_t kMaxCameras = 8;

/// Dark, blurred spots at fixed places of the pictures.
struct LensDirt {
  double share = 0;  ///< of the light that the middle of a spot takes
  int spots = 1;
  double size = 0;            ///< mean radius of a spot, as a share of the picture's width
  std::uint64_t pattern = 0;  ///< number of the spots' places

  bool operator==(const LensDirt&) const = default;
};

/// Brightness that swings with the simulated time.
struct Flicker {
  double share = 0;  ///< of the brightness that is missing at the darkest moment
  double rate_hz = 1;

  bool operator==(const Flicker&) const = default;
};

/// A camera whose pictures are rendered. It detects nothing: see Vision for the text lines.
struct Camera {
  std::string name;
  int robot = -1;    ///< that it serves: index into Scene::robots; -1 = none
  int carrier = -1;  ///< robot whose flange it is mounted on; -1 = it is fixed
  Pose X_PC;         ///< camera frame in the carrier's flange; of a fixed one in the world
  Lens lens;
  double rate_hz = 10;
  double latency_s = 0;  ///< from exposure until the picture is out
  int jpeg_quality = 80;
  double exposure = 1;   ///< factor on the brightness
  double noise = 0;      ///< standard deviation in each colour [1/255]
  double blur_px = 0.5;  ///< standard deviation of a point's picture
  std::vector<LensDirt> dirt;
  std::vector<Flicker> flicker;

  [[nodiscard]] bool is_fixed() const { return carrier < 0; }
};

}  // namespace aprsim::scene
