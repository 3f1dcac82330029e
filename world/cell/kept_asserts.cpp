#include "world/cell/kept_asserts.hpp"

#include <Eigen/Core>

#include "world/physics/bodies/ode_library.hpp"

namespace aprsim::world {

std::vector<std::string> kept_asserts() {
  std::vector<std::string> kept;
#ifndef NDEBUG
  kept.emplace_back("aprsim");
#endif
#ifndef EIGEN_NO_DEBUG
  kept.emplace_back("Eigen");
#endif
  if (physics::ode_keeps_asserts()) kept.emplace_back("ODE");
  return kept;
}

}  // namespace aprsim::world
