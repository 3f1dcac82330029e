#pragma once

#include <cstdint>
#include <vector>

#include "world/scene/model/scene.hpp"

/// A hand takes parts one after another out of a kit of a hundred and puts each into another kit.
namespace aprsim::bench {

struct KitPicking {
  int picked = 0, placed = 0;
  double deepest_m = 0;
  double moved_m = 0;           ///< greatest way of a part in the kit that was not taken yet
  std::vector<double> step_us;  ///< of every step after the first second
  std::uint64_t unsolved = 0;
};
[[nodiscard]] KitPicking pick_kit(scene::Simplification mode, int picks);

}  // namespace aprsim::bench
