#include "world/physics/step/make_engine.hpp"

#include "world/physics/constraint/constraint_system.hpp"

namespace aprsim::physics {

std::unique_ptr<Engine> make_engine(const scene::Physics& /*physics*/) {
  return std::make_unique<ConstraintSystem>();
}

}  // namespace aprsim::physics
