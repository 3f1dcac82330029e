#pragma once

#include <ctime>
#include <stdexcept>

namespace aprsim::bench {

inline double clock_s(clockid_t clock) {
  timespec now{};
  if (clock_gettime(clock, &now) != 0) throw std::runtime_error("no CPU clock");
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// CPU time of the calling thread [s]: what others do on the machine costs caches, not seconds.
inline double thread_cpu_s() { return clock_s(CLOCK_THREAD_CPUTIME_ID); }
/// That of all threads of the program [s].
inline double process_cpu_s() { return clock_s(CLOCK_PROCESS_CPUTIME_ID); }

}  // namespace aprsim::bench
