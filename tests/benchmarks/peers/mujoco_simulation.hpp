#pragma once

#include <memory>
#include <string>

#include "tests/benchmarks/trays/tray_simulation.hpp"

namespace aprsim::bench {

struct MujocoSettings {
  const char* name;
  double solref_s = 0.02;  ///< time constant of contacts; at least two steps
  bool accurate = false;   ///< elliptic cones, impratio 10, five no-slip iterations
};

std::unique_ptr<TraySimulation> mujoco_simulation(const scene::Scene& scene,
                                                  const MujocoSettings& settings);
std::string mujoco_version();

}  // namespace aprsim::bench
