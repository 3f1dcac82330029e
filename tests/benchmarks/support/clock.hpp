#pragma once

#include <ctime>
#include <stdexcept>

namespace aprsim::bench {

/// CPU time of the calling thread [s]: what others do on the machine costs caches, not seconds.
inline double thread_cpu_s() {
  timespec now{};
  if (clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now) != 0) throw std::runtime_error("no CPU clock");
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace aprsim::bench
