#pragma once

#include "world/physics/constraint/contact_problem.hpp"
#include "world/physics/constraint/contact_solver_parameters.hpp"
#include "world/physics/constraint/saved_impulses.hpp"
#include "world/physics/constraint/tolerance_schedule.hpp"

namespace aprsim::physics {

/// Whether a warm start is so far off that an impact must be the reason. Problems with rows are not
/// relaxed: how firmly a gripper holds depends on how its contacts share the load, which has to
/// change as little as possible.
[[nodiscard]] bool needs_relaxation(const ContactProblem& problem,
                                    const ContactSolverParameters& parameters,
                                    const ContactResidual& first);

/// A few rounds of nonlinear Gauss-Seidel (Jourdan et al. 1998) find cheaply which contacts bear an
/// impact, and which slip. They count if the residual is less than the `first` one, which is that
/// of the present impulses. Returns the residual. `saved` is overwritten.
[[nodiscard]] ContactResidual relax_impact(ContactProblem& problem,
                                           const ContactSolverParameters& parameters,
                                           const ToleranceSchedule& tolerance,
                                           const ContactResidual& first, SavedImpulses& saved);

}  // namespace aprsim::physics
