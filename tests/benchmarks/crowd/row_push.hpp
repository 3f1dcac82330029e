#pragma once

#include <random>

#include "world/scene/model/scene.hpp"

/// A hand that holds a gear just over a table pushes it through a row of loose ones.
namespace aprsim::bench {

struct RowCase {
  scene::Simplification mode = scene::Simplification::kOff;
  int gears = 4;           ///< in the row
  double heading_rad = 0;  ///< of the push and the row
  double hand_yaw_rad = 0;
  double speed_m_s = 0.2;
  double scatter_m = 0;  ///< of the gears to either side of the row
  unsigned seed = 1;     ///< of where they stand
};

struct RowResult {
  bool held = false;                ///< from the first to the last step
  double slip_m = 0, slip_rad = 0;  ///< greatest, in the hand
  double deepest_m = 0;
  double load_n = 0;                   ///< greatest across the grip, from the gears
  double step_us = 0, longest_us = 0;  ///< while it pushes
  std::uint64_t unsolved = 0;
};
[[nodiscard]] RowResult push_row(const RowCase& the_case);

}  // namespace aprsim::bench
