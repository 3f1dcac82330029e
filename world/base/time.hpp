#pragma once

#include <chrono>

namespace aprsim {

/// Simulated time since the last reset: step count times the fixed step, never a wall clock.
using SimTime = std::chrono::nanoseconds;

[[nodiscard]] inline double seconds(SimTime t) { return std::chrono::duration<double>(t).count(); }

}  // namespace aprsim
