#pragma once

#include "world/physics/constraint/contact_problem.hpp"
#include "world/physics/constraint/contact_solver_outcome.hpp"
#include "world/physics/constraint/contact_solver_parameters.hpp"
#include "world/physics/constraint/contact_solver_statistics.hpp"
#include "world/physics/constraint/large_island_solver.hpp"
#include "world/physics/constraint/proximal_point.hpp"
#include "world/physics/constraint/saved_impulses.hpp"

namespace aprsim::physics {

/// Solves a ContactProblem. Coulomb's law holds with circular cones, for sliding contacts, too.
/// Everything is implicit, for any ratio of masses. Contacts are hard up to their compliance.
///
/// Method, with equations, symbols and limits: docs/contact_solver.md. Its parts, one per file:
/// 1. `warm_start`: the better of the last impulses and their linear extrapolation.
/// 2. `impact_relaxation`: after an impact a few rounds of nonlinear Gauss-Seidel.
/// 3. `ProximalPoint`: the outer iteration on the impulses (augmented Lagrangian), with the
///    adaptation of its weight (`ProximalWeight`) and the `ToleranceSchedule`.
/// 4. `NewtonSolver`: for a proximal point the impulses are functions of the bodies' velocities,
/// and
///    a semismooth Newton method with backtracking finds these. The correction that makes Coulomb's
///    friction associated (De Saxce) follows within it. Where that makes no progress the correction
///    is held: the subproblem is then convex, and a line search always approaches its minimum.
/// 5. `NewtonMatrix`, `BlockLu`: the matrix, unsymmetric because of the correction, in sparse
/// blocks
///    of 6 by 6.
/// 6. `LargeIslandSolver`: in place of 3. for islands of many bodies, with `RegionSolver`.
///
/// Sources: De Saxce & Feng 1998 (cone complementarity of Coulomb friction); Jourdan et al. 1998
/// (Gauss-Seidel); Cadoux 2009, Acary et al. 2011 (fixed point on the slip); Rockafellar 1976
/// (proximal method of multipliers); Castro et al. 2022, SAP (the convex problem in velocities and
/// its derivatives); Todorov 2014.
///
/// No call allocates after warm-up. The same input gives the same bits.
class ContactSolver {
 public:
  using Outcome = ContactSolverOutcome;

  /// Brings the problem's iterate to the solution.
  Outcome solve(ContactProblem& problem, const ContactSolverParameters& parameters = {});
  /// The course of the last solve().
  [[nodiscard]] const ContactSolverStatistics& statistics() const { return statistics_; }

 private:
  ProximalPoint proximal_point_;
  LargeIslandSolver large_island_;
  SavedImpulses saved_;
  ContactSolverStatistics statistics_;
};

}  // namespace aprsim::physics
