#pragma once

#include <string>
#include <vector>

#include "world/scene/model/scene.hpp"

namespace aprsim::bench {

/// An engine with its settings, and its name in tables and of results.
struct EngineSetting {
  std::string name, key;
  scene::PhysicsEngine engine = scene::PhysicsEngine::kAprsim;
  scene::OdeSettings ode;

  [[nodiscard]] bool is_ode() const { return engine == scene::PhysicsEngine::kOde; }
  void apply(scene::Physics& physics) const {
    physics.engine = engine;
    physics.ode = ode;
  }
};

/// Our engine, ODE's iterative stepper with several numbers of iterations, and its direct one.
[[nodiscard]] inline std::vector<EngineSetting> engine_settings(bool quick) {
  using Stepper = scene::OdeSettings::Stepper;
  std::vector<EngineSetting> out = {{"aprsim", "aprsim"}};
  for (const int iterations : quick ? std::vector{200} : std::vector{20, 50, 200}) {
    out.push_back({"ode quick " + std::to_string(iterations),
                   "ode_quick_" + std::to_string(iterations),
                   scene::PhysicsEngine::kOde,
                   {.stepper = Stepper::kQuick, .iterations = iterations}});
  }
  out.push_back(
      {"ode direct", "ode_direct", scene::PhysicsEngine::kOde, {.stepper = Stepper::kDirect}});
  return out;
}

}  // namespace aprsim::bench
