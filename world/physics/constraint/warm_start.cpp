#include "world/physics/constraint/warm_start.hpp"

namespace aprsim::physics {

ContactResidual warm_start(ContactProblem& problem, const ContactSolverParameters& parameters,
                           const ToleranceSchedule& tolerance, SavedImpulses& saved) {
  // Both guesses are compared by the residual that they cause, never by their size.
  // Extrapolated impulses: exact while forces change linearly.
  const ContactResidual extrapolated = problem.residual(parameters);
  if (tolerance.accepts(extrapolated, 0)) return extrapolated;
  // The last impulses: better where a force has just changed.
  saved.save(problem);
  problem.set_last_impulses();
  const ContactResidual last = problem.residual(parameters);
  if (tolerance.excess_m_s(last) < tolerance.excess_m_s(extrapolated)) return last;
  saved.restore(problem);
  problem.update_velocities();
  return extrapolated;
}

}  // namespace aprsim::physics
