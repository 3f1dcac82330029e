#pragma once

#include <random>

#include "world/scene/model/scene.hpp"

namespace aprsim::bench {

/// A pillar of equal discs or slabs upon a slope. SI.
struct Pillar {
  bool slabs = false;
  int count = 2;
  double radius_m = 0.03;     ///< of the discs; of slabs half the width along the slope
  double thickness_m = 0.02;  ///< of each
  double mass_kg = 0.05;      ///< of each
  double heading_rad = 0;     ///< of the slope
  scene::Simplification mode = scene::Simplification::kDormant;
  double step_s = 1e-3;

  /// Slope on which the centre of mass is above the edge of the foot [rad].
  [[nodiscard]] double toppling_rad() const;
};

/// One that topples at a slope of 0.1 to 0.5 rad.
[[nodiscard]] Pillar random_pillar(std::mt19937_64& engine, bool slabs, int count);

/// Whether the pillar, set upon that slope, has toppled within some seconds.
[[nodiscard]] bool topples(const Pillar& pillar, double slope_rad);

}  // namespace aprsim::bench
