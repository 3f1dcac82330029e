#pragma once

#include <limits>
#include <string>

namespace aprsim::server {

/// Options for the files that a replay writes: the motion, and the pictures of a camera.
struct MotionOptions {
  std::string file;     ///< of the motion; empty = none
  std::string video;    ///< of the pictures; empty = none
  std::string camera;   ///< whose pictures
  double rate_hz = 50;  ///< samples a second of simulated time, at most 1000
  double from_s = 0;    ///< simulated time since the run's beginning, resets included
  double to_s = std::numeric_limits<double>::infinity();
};

}  // namespace aprsim::server
