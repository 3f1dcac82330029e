#include "world/physics/collision/circle_maxima.hpp"

namespace aprsim::physics::detail {

const std::array<Direction, kRingSamples>& sample_directions() {
  // Computed once: every circle of every pair starts from these.
  static const std::array<Direction, kRingSamples> directions = [] {
    std::array<Direction, kRingSamples> d;
    for (int i = 0; i < kRingSamples; ++i) {
      d[static_cast<std::size_t>(i)] = {std::cos(kSampleAngle * i), std::sin(kSampleAngle * i)};
    }
    return d;
  }();
  return directions;
}

}  // namespace aprsim::physics::detail
