#include "world/physics/step/make_engine.hpp"

#include "world/physics/constraint/constraint_system.hpp"
#include "world/physics/ode/ode_engine.hpp"

namespace aprsim::physics {

std::unique_ptr<Engine> make_engine(const scene::Physics& physics) {
  if (physics.engine == scene::PhysicsEngine::kOde) return std::make_unique<OdeEngine>(physics.ode);
  return std::make_unique<ConstraintSystem>();
}

}  // namespace aprsim::physics
