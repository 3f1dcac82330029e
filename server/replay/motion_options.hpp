#pragma once

#include <limits>
#include <string>

namespace aprsim::server {

/// Options for the motion file of a replay.
struct MotionOptions {
  std::string file;     ///< empty = none
  double rate_hz = 50;  ///< snapshots a second of simulated time, at most 1000
  double from_s = 0;    ///< simulated time since the run's beginning, resets included
  double to_s = std::numeric_limits<double>::infinity();
};

}  // namespace aprsim::server
