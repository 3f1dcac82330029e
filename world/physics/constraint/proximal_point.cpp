#include "world/physics/constraint/proximal_point.hpp"

#include <algorithm>

namespace aprsim::physics {
namespace {

void record(const NewtonSolver::Result& subproblem, double proximal_weight, double tolerance_m_s,
            double residual_m_s, bool accepted, ContactSolverStatistics& statistics) {
  statistics.record({.proximal_weight = proximal_weight,
                     .residual_m_s = residual_m_s,
                     .tolerance_m_s = tolerance_m_s,
                     .newton_steps = subproblem.steps,
                     .line_search_steps = subproblem.line_search_steps,
                     .shortest_step = subproblem.shortest_step,
                     .held_slip = subproblem.held_slip,
                     .accepted = accepted});
}

}  // namespace

ContactSolverOutcome ProximalPoint::solve(ContactProblem& problem,
                                          const ContactSolverParameters& parameters,
                                          const ToleranceSchedule& tolerance,
                                          const ContactResidual& first, SavedImpulses& best,
                                          ContactSolverStatistics& statistics) {
  ContactSolverOutcome outcome;
  ContactResidual residual = first;
  // The residual in excess of the slack of unactuated contacts decides; one number orders all
  // iterates.
  double best_m_s = tolerance.excess_m_s(first), last_m_s = best_m_s;
  newton_.prepare(problem);
  best.save(problem);
  ProximalWeight weight(parameters, first.max_m_s());
  while (outcome.newton_steps < parameters.max_newton_steps) {
    // gamma <- argmin of the dual cost + weight W / 2 |gamma - proximal_gamma|^2. Redundant
    // contacts leave the impulses of the original problem undetermined; the proximal term selects
    // those next to the warm start.
    // The subproblem about the present impulses.
    problem.set_proximal_weight(weight.value(), parameters);
    problem.update_proximal_point();
    // Inexact solution: to a share of the residual, at most to a share of the tolerance.
    const NewtonSolver::Result subproblem = newton_.solve(
        problem, parameters,
        {.tolerance_m_s =
             std::max(parameters.newton_tolerance_share * tolerance.after(outcome.newton_steps),
                      parameters.newton_relative_tolerance * residual.max_m_s()),
         .max_steps = parameters.max_newton_steps - outcome.newton_steps,
         .may_hold_slip = weight.is_max()});
    outcome.newton_steps += subproblem.steps;
    const double tolerance_m_s = tolerance.after(outcome.newton_steps);
    // A subproblem that failed starts again from its proximal point, with a larger weight.
    if (!subproblem.solved && !weight.is_max()) {
      record(subproblem, weight.value(), tolerance_m_s, residual.max_m_s(), false, statistics);
      problem.return_to_proximal_point();
      weight.increase();
      continue;
    }
    // Stop where the impulses fulfil Coulomb's law at the velocities that they cause.
    residual = problem.residual(parameters);
    record(subproblem, weight.value(), tolerance_m_s, residual.max_m_s(), true, statistics);
    const double excess_m_s = tolerance.excess_m_s(residual);
    if (excess_m_s <= tolerance_m_s) {
      outcome.converged = true;
      outcome.residual_m_s = residual.max_m_s();
      return outcome;
    }
    // The residual need not fall each time: the best iterate is kept.
    if (excess_m_s < best_m_s) {
      best_m_s = excess_m_s;
      best.save(problem);
    }
    // The next subproblem starts at Newton's velocities, with an adapted weight.
    problem.return_to_newton_velocities();
    weight.adapt(subproblem.directions, excess_m_s / last_m_s);
    last_m_s = excess_m_s;
  }
  // Out of Newton steps: the best iterate, converged only if the schedule accepts it by now.
  best.restore(problem);
  const ContactResidual last = problem.residual(parameters);
  outcome.residual_m_s = last.max_m_s();
  outcome.converged = tolerance.accepts(last, outcome.newton_steps);
  return outcome;
}

}  // namespace aprsim::physics
