#pragma once

#include <random>

#include "tests/benchmarks/friction/verdict.hpp"
#include "world/scene/model/scene.hpp"

/// A slab on a table that a hand presses down and drags along, stuck to it.
namespace aprsim::bench {

struct SlabCase {
  scene::Simplification mode = scene::Simplification::kOff;
  double heading_rad = 0;  ///< in which it is dragged
  double slab_yaw_rad = 0, hand_yaw_rad = 0;
  double friction = 0.4;  ///< of slab and table
  double press_m = 1e-3;  ///< by which the hand's soft mount is pressed
};

/// The load over its limit is the hand's horizontal force over mu (its vertical force + weight).
[[nodiscard]] Verdict drag(const SlabCase& the_case);

[[nodiscard]] SlabCase random_slab(std::mt19937_64& engine);

}  // namespace aprsim::bench
