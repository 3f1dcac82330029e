#include "world/cell/standstill.hpp"

#include <algorithm>

namespace aprsim::world {

void Standstill::prove(bool reads_sensors, const std::string& expected, const std::string& now) {
  if (expected == now) {
    (reads_sensors ? proven_with_sensors_ : proven_without_) = true;
    return;
  }
  // Something goes on that moves neither body nor joint: the next attempt comes later.
  const std::uint64_t longer = std::min(2 * interval_steps_, kLongestInterval);
  end();
  interval_steps_ = wait_steps_ = longer;
}

}  // namespace aprsim::world
