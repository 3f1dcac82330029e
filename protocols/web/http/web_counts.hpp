#pragma once

#include <chrono>
#include <cstdint>

#include "world/base/duration_histogram.hpp"

namespace aprsim::web {

/// Counts the requests to the web listener. Thread: the server's.
struct WebCounts {
  std::uint64_t requests = 0;  ///< over HTTP and over WebSockets
  std::uint64_t failed = 0;    ///< answered with an error
  std::uint64_t skipped = 0;   ///< snapshots dropped for slow viewers
  api::DurationHistogram answer_times;

  void answered(std::chrono::nanoseconds after, bool ok) {
    if (!ok) ++failed;
    answer_times.add(after);
  }
};

}  // namespace aprsim::web
