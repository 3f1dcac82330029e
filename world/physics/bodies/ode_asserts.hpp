#pragma once

namespace aprsim::physics {

/// Whether the ODE that is linked checks its arguments and invariants; what fails throws a
/// PhysicsFailure.
[[nodiscard]] bool ode_keeps_asserts();

}  // namespace aprsim::physics
