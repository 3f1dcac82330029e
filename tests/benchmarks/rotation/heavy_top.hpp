#pragma once

#include <random>

#include "world/scene/model/scene.hpp"

namespace aprsim::bench {

/// A disc on the point of a cone that spins on a plate. SI.
struct Top {
  double disc_radius_m = 0.04, disc_height_m = 0.006;
  double point_m = 0.03;  ///< from the disc to the point
  double mass_kg = 0.05;
  double tilt_rad = 0.3;
  double spin_rad_s = 150;  ///< about its axis
  bool steady = false;      ///< starts in regular precession, otherwise without precession
  double friction = 1;      ///< 0: its centre of mass moves along the vertical
  double heading_rad = 0;   ///< of the axis at the start
  scene::Simplification mode = scene::Simplification::kDormant;
  double step_s = 1e-3;
};

[[nodiscard]] Top random_top(std::mt19937_64& engine);

/// Errors after a time, against the integrated equations of a symmetric top.
struct TopErrors {
  double tilt_rad = 0, precession_rad = 0;  ///< at the end, integrated
  double tilt = 0;        ///< of the least and the greatest in the last second, over the latter
  double precession = 0;  ///< difference at the end over the way
  double point_m = 0;     ///< greatest distance of the point from where it stood
};
[[nodiscard]] TopErrors spin(const Top& top, double seconds);

}  // namespace aprsim::bench
