#pragma once

#include <random>

#include "tests/benchmarks/friction/verdict.hpp"
#include "world/scene/model/scene.hpp"

/// A tray or a gear on an inclined plate: tan(inclination) over mu is the load over its limit.
namespace aprsim::bench {

struct ChuteCase {
  scene::Simplification mode = scene::Simplification::kOff;
  bool gear = false;       ///< else a tray
  double heading_rad = 0;  ///< downhill
  double yaw_rad = 0;      ///< of what lies on it, about the plate's normal
  double friction = 0.4;
};

/// Each load has a plate of its own; the onset is found by that many halvings from 0.9 to 1.1.
[[nodiscard]] Verdict chute(const ChuteCase& the_case, int halvings);

[[nodiscard]] ChuteCase random_chute(std::mt19937_64& engine, bool gear);

}  // namespace aprsim::bench
