#include "world/physics/constraint/large_island_solver.hpp"

#include <algorithm>
#include <tuple>

namespace aprsim::physics {

ContactSolverOutcome LargeIslandSolver::solve(ContactProblem& problem,
                                              const ContactSolverParameters& parameters,
                                              const ToleranceSchedule& tolerance,
                                              const ContactResidual& first, SavedImpulses& best,
                                              ContactSolverStatistics& statistics) {
  Course course{.problem = problem,
                .parameters = parameters,
                .tolerance = tolerance,
                .best = best,
                .residual = first,
                .best_m_s = tolerance.excess_m_s(first),
                .last_m_s = tolerance.excess_m_s(first)};
  best.save(problem);
  // A disturbance that is local, such as an impact or contacts that were found later, ends here.
  std::ignore = solve_regions(course);
  course.keep_best();
  course.last_m_s = course.excess_m_s();
  bool prepared = false;
  ProximalWeight weight(parameters, course.residual.max_m_s());
  while (!course.is_solved() && course.steps() < parameters.max_newton_steps) {
    if (!prepared) newton_.prepare(problem);
    prepared = true;
    const double used_weight = weight.value();
    const NewtonSolver::Result subproblem = solve_subproblem(course, weight);
    const bool failed = !subproblem.solved && !weight.is_max();
    if (failed) {
      keep_progress(course);
      weight.increase();
    } else {
      course.residual = problem.residual(parameters);
      // Without regions the next subproblem starts at Newton's velocities.
      if (!course.is_solved() && !solve_regions(course)) problem.return_to_newton_velocities();
      weight.adapt(subproblem.directions, course.excess_m_s() / course.last_m_s);
    }
    course.last_m_s = course.excess_m_s();
    if (!failed) course.keep_best();
    statistics.record({.proximal_weight = used_weight,
                       .residual_m_s = course.residual.max_m_s(),
                       .tolerance_m_s = tolerance.after(course.steps()),
                       .newton_steps = subproblem.steps,
                       .line_search_steps = subproblem.line_search_steps,
                       .shortest_step = subproblem.shortest_step,
                       .held_slip = subproblem.held_slip,
                       .accepted = !failed});
  }
  // Velocities are those of the impulses: momentum is balanced, whatever the residual.
  if (!course.is_solved()) best.restore(problem);
  const ContactResidual last = problem.residual(parameters);
  return {.converged = tolerance.accepts(last, course.steps()),
          .newton_steps = course.steps(),
          .residual_m_s = last.max_m_s()};
}

void LargeIslandSolver::Course::keep_best() {
  if (!(excess_m_s() < best_m_s)) return;
  best_m_s = excess_m_s();
  best.save(problem);
}

/// Whether the impulses have changed; the velocities are then those of the impulses.
bool LargeIslandSolver::solve_regions(Course& course) {
  const RegionSolver::Result result =
      regions_.solve(course.problem, course.parameters, course.tolerance,
                     course.tolerance.after(course.steps()), course.residual);
  course.residual = result.residual;
  course.newton_steps += result.newton_steps;
  return result.regions > 0;
}

/// The subproblem about the present impulses.
NewtonSolver::Result LargeIslandSolver::solve_subproblem(Course& course,
                                                         const ProximalWeight& weight) {
  const ContactSolverParameters& parameters = course.parameters;
  course.problem.set_proximal_weight(weight.value(), parameters);
  course.problem.update_proximal_point();
  const double share_m_s =
      parameters.newton_tolerance_share * course.tolerance.after(course.steps());
  const NewtonSolver::Result result = newton_.solve(
      course.problem, parameters,
      {.tolerance_m_s =
           std::max(share_m_s, parameters.newton_relative_tolerance * course.residual.max_m_s()),
       .max_steps = parameters.max_newton_steps - course.steps(),
       .may_hold_slip = weight.is_max()});
  course.newton_steps += result.steps;
  return result;
}

/// After a subproblem that failed: its last impulses, if they are better than the proximal point.
void LargeIslandSolver::keep_progress(Course& course) {
  const ContactResidual now = course.problem.residual(course.parameters);
  if (course.tolerance.excess_m_s(now) < course.excess_m_s()) {
    course.residual = now;
    course.keep_best();
    return;
  }
  course.problem.return_to_proximal_point();
}

}  // namespace aprsim::physics
