#pragma once

#include <memory>
#include <string>

#include "tests/benchmarks/trays/tray_simulation.hpp"

namespace aprsim::bench {

struct BulletSettings {
  const char* name;
  int iterations = 10;
  double scale = 1;  ///< units per metre: its manual advises against objects under 0.2 units
  double margin_m = 4e-2;
};

std::unique_ptr<TraySimulation> bullet_simulation(const scene::Scene& scene,
                                                  const BulletSettings& settings);
std::string bullet_version();

}  // namespace aprsim::bench
