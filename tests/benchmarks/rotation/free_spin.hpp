#pragma once

#include <random>

#include "world/scene/model/scene.hpp"

namespace aprsim::bench {

/// A gear or slab of random size that turns freely, without gravity.
struct FreeSpin {
  scene::Scene scene;
  Eigen::Vector3d omega_W = Eigen::Vector3d::Zero();
};

/// At 1 to `max_rad_s` about any axis.
[[nodiscard]] FreeSpin random_free_spin(std::mt19937_64& engine, double max_rad_s);

/// Greatest errors at any second of a free spin, relative.
struct SpinErrors {
  double energy = 0, angular_momentum = 0;
};
[[nodiscard]] SpinErrors errors_of(const FreeSpin& spin, double seconds);

}  // namespace aprsim::bench
