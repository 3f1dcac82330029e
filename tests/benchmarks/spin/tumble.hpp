#pragma once

#include <cstdint>
#include <vector>

#include "world/scene/model/scene.hpp"

namespace aprsim::bench {

/// Ten trays with four gears each, at any attitude over a table. The same seed, the same attitudes.
[[nodiscard]] scene::Scene tumbling_trays(scene::Simplification mode, unsigned seed);

struct Tumble {
  double gained_j = 0;  ///< all gains of energy after the first impact, added up
  double deepest_m = 0;
  double energy_j = 0;  ///< in the beginning, over that at the end
  std::vector<double> step_us;
  std::uint64_t unsolved = 0;
};
/// They fall, spinning, and what was in the trays spills.
[[nodiscard]] Tumble tumble(scene::Simplification mode, unsigned seed, double seconds);

}  // namespace aprsim::bench
