#pragma once

#include <array>

#include "world/scene/model/scene.hpp"

/// A closed gripper pushes a light tray with heavy parts in it over a table.
namespace aprsim::bench {

struct PushCase {
  scene::Simplification mode = scene::Simplification::kOff;
  /// Masses of the two parts at the pushed side and of the two at the other: pairs of one mass, so
  /// that the tray is pushed through its centre of mass and does not turn.
  std::array<double, 2> part_kg{1, 1};
  double heading_rad = 0;
};

struct PushResult {
  double pusher_m_s = 0;  ///< greatest speed of the finger tips, as the soft mount lets them
  double part_m_s = 0;    ///< greatest speed of a part's centre of mass
  double hand_m_s = 0;    ///< greatest speed of the hand before the mount
  double deepest_m = 0;
  bool faults = false;  ///< a part is out of its pocket, or the world stopped
  double step_us = 0, longest_us = 0;
  std::uint64_t unsolved = 0;
};
[[nodiscard]] PushResult push_tray(const PushCase& the_case);

}  // namespace aprsim::bench
