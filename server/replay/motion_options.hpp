#pragma once

#include <limits>
#include <string>

namespace aprsim::server {

/// How a replay writes what moves.
struct MotionOptions {
  std::string file;     ///< empty = none is written
  double rate_hz = 50;  ///< snapshots a second of simulated time, at most 1000
  double from_s = 0;    ///< simulated time since the run's beginning, also over resets
  double to_s = std::numeric_limits<double>::infinity();
};

}  // namespace aprsim::server
