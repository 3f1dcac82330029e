#pragma once

#include <memory>

#include "tests/benchmarks/trays/tray_simulation.hpp"

namespace aprsim::bench {

/// Trays and gears in ODE with its iterative solver (dWorldQuickStep): its bodies and contact
/// joints at the points of our own contact search, so that both solve the same problem. Bodies at
/// rest are not put to sleep. The scene must outlive it.
class OdeSimulation : public TraySimulation {
 public:
  /// How deep anything was in anything else, in the last step.
  [[nodiscard]] virtual double deepest_m() const = 0;
};
std::unique_ptr<OdeSimulation> ode_simulation(const scene::Scene& scene, int iterations);

}  // namespace aprsim::bench
