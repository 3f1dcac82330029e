#pragma once

#include <ostream>
#include <vector>

#include "world/scene/model/scene.hpp"

namespace aprsim::physics::test {

/// An engine with its stepper.
struct EngineCase {
  const char* name = "";
  scene::PhysicsEngine engine = scene::PhysicsEngine::kAprsim;
  scene::OdeSettings::Stepper stepper = scene::OdeSettings::Stepper::kQuick;

  [[nodiscard]] bool is_ode() const { return engine == scene::PhysicsEngine::kOde; }
  void apply(scene::Physics& physics) const {
    physics.engine = engine;
    physics.ode.stepper = stepper;
  }
};

inline void PrintTo(const EngineCase& engine, std::ostream* out) { *out << engine.name; }

inline const std::vector<EngineCase> kEngines = {
    {"aprsim"},
    {"ode_quick", scene::PhysicsEngine::kOde},
    {"ode_direct", scene::PhysicsEngine::kOde, scene::OdeSettings::Stepper::kDirect}};

}  // namespace aprsim::physics::test
