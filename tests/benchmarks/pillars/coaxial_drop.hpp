#pragma once

#include <cstdint>

namespace aprsim::bench {

/// A disc dropped on another one, nearly or exactly upon its axis.
struct CoaxialDrop {
  double off_axis_m = 0, tilt_rad = 0, height_m = 0;
  bool equal = false;    ///< both are of one type
  double sunk_m = 0;     ///< the upper one in the lower one at the end
  double deepest_m = 0;  ///< penetration in any step
  [[nodiscard]] bool passed() const { return sunk_m > 1e-3; }
};

/// The same seed gives the same drop: discs and gears of random size, 0 or 1e-12 to 1e-3 m off the
/// axis, tilted by 0 or 1e-9 to 1e-3 rad.
[[nodiscard]] CoaxialDrop coaxial_drop(std::uint64_t seed);

}  // namespace aprsim::bench
