#pragma once

#include "world/physics/constraint/contact_problem.hpp"
#include "world/physics/constraint/contact_solver_parameters.hpp"
#include "world/physics/constraint/saved_impulses.hpp"
#include "world/physics/constraint/tolerance_schedule.hpp"

namespace aprsim::physics {

/// Sets the better of two warm starts, by their residuals: the impulses of the last step, and these
/// extrapolated linearly, which the problem has after complete(). Returns its residual. `saved` is
/// overwritten.
[[nodiscard]] ContactResidual warm_start(ContactProblem& problem,
                                         const ContactSolverParameters& parameters,
                                         const ToleranceSchedule& tolerance, SavedImpulses& saved);

}  // namespace aprsim::physics
