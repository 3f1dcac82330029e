#pragma once

#include "world/physics/constraint/contact_problem.hpp"
#include "world/physics/constraint/contact_solver_outcome.hpp"
#include "world/physics/constraint/contact_solver_parameters.hpp"
#include "world/physics/constraint/contact_solver_statistics.hpp"
#include "world/physics/constraint/newton_solver.hpp"
#include "world/physics/constraint/proximal_weight.hpp"
#include "world/physics/constraint/saved_impulses.hpp"
#include "world/physics/constraint/tolerance_schedule.hpp"

namespace aprsim::physics {

/// The outer iteration: the proximal point method on the impulses (augmented Lagrangian;
/// Rockafellar 1976). Each iteration adds weight * W / 2 |gamma - proximal_gamma|^2, which makes
/// the impulses unique functions of the velocities; a Newton solve finds these, and its impulses
/// are the next proximal point. No call allocates after warm-up.
class ProximalPoint {
 public:
  /// From the problem's present impulses and velocities, whose residual is `first`. `best` is
  /// overwritten. `statistics` receives each outer iteration.
  [[nodiscard]] ContactSolverOutcome solve(ContactProblem& problem,
                                           const ContactSolverParameters& parameters,
                                           const ToleranceSchedule& tolerance,
                                           const ContactResidual& first, SavedImpulses& best,
                                           ContactSolverStatistics& statistics);

 private:
  NewtonSolver newton_;
};

}  // namespace aprsim::physics
