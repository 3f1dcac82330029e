#include "world/physics/bodies/ode_asserts.hpp"

#include <ode/ode.h>

namespace aprsim::physics {

bool ode_keeps_asserts() { return dCheckConfiguration("ODE_EXT_no_debug") == 0; }

}  // namespace aprsim::physics
