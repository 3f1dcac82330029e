#pragma once

namespace aprsim::physics {

/// Initialises ODE: the library once a process, its data once a thread. To be called before any
/// other call of ODE in a thread; cheap when done before. From then on errors and failed assertions
/// of ODE throw PhysicsFailure. Throws PhysicsFailure.
void prepare_ode();

/// Whether the linked ODE checks its arguments and invariants.
[[nodiscard]] bool ode_keeps_asserts();

}  // namespace aprsim::physics
