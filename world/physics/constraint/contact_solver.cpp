#include "world/physics/constraint/contact_solver.hpp"

#include "world/physics/constraint/impact_relaxation.hpp"
#include "world/physics/constraint/tolerance_schedule.hpp"
#include "world/physics/constraint/warm_start.hpp"

namespace aprsim::physics {

ContactSolver::Outcome ContactSolver::solve(ContactProblem& problem,
                                            const ContactSolverParameters& original) {
  statistics_.clear();
  problem.complete(original);
  if (problem.moving().empty()) return {.converged = true};
  const bool is_large =
      problem.moving().size() > static_cast<std::size_t>(original.max_small_island_bodies);
  const ContactSolverParameters parameters =
      is_large ? for_large_island(original, problem.is_at_rest() || !problem.rows().empty())
               : original;
  const ToleranceSchedule tolerance(parameters, problem.is_at_rest());
  // The outer iteration is only entered if neither warm start nor relaxation fulfils Coulomb's law.
  // In a quiet cell most steps end here.
  // Warm start.
  ContactResidual residual = warm_start(problem, parameters, tolerance, saved_);
  statistics_.initial_residual_m_s = residual.max_m_s();
  // Relaxation after an impact.
  statistics_.relaxed = needs_relaxation(problem, parameters, residual);
  if (statistics_.relaxed) {
    residual = relax_impact(problem, parameters, tolerance, residual, saved_);
  }
  statistics_.start_residual_m_s = residual.max_m_s();
  if (tolerance.accepts(residual, 0)) {
    return {.converged = true,
            .warm_start_fits = !statistics_.relaxed && problem.rows().empty(),
            .residual_m_s = residual.max_m_s()};
  }
  // Outer iteration.
  if (is_large) {
    return large_island_.solve(problem, parameters, tolerance, residual, saved_, statistics_);
  }
  return proximal_point_.solve(problem, parameters, tolerance, residual, saved_, statistics_);
}

}  // namespace aprsim::physics
