#include "world/physics/constraint/impact_relaxation.hpp"

#include "world/base/simd/vector_clones.hpp"

namespace aprsim::physics {
namespace {

/// One round, pair of bodies by pair. The contacts of a pair share the load at the same velocities
/// (mass splitting: Tonge et al. 2012). In turns the first ones would take it, and how a sliding
/// body rotates depends on how evenly its load is borne.
APRSIM_VECTOR_CLONES void relax(ContactProblem& problem) {
  for (std::size_t first = 0; first < problem.packs().size();) {
    const auto pair = problem.packs_of_pair(first);
    first += pair.size();
    // Gauss-Seidel between pairs, Jacobi within a pair.
    // Velocities after all earlier pairs, and the number of contacts that share the load.
    int bearing = 0;
    for (ContactPack& pack : pair) {
      pack.evaluate_contact_velocities(problem.find(pack.a), problem.find(pack.b));
      bearing += pack.bearing_count();
    }
    if (bearing == 0) continue;
    // A share of the projected step of each contact, and the bodies' new velocities.
    const double share = 1.0 / bearing;
    for (ContactPack& pack : pair) {
      problem.apply_impulse(pack, pack.body_impulses(pack.relax(share)));
    }
  }
}

}  // namespace

bool needs_relaxation(const ContactProblem& problem, const ContactSolverParameters& parameters,
                      const ContactResidual& first) {
  return problem.rows().empty() && first.max_m_s() > parameters.impact_residual_m_s;
}

ContactResidual relax_impact(ContactProblem& problem, const ContactSolverParameters& parameters,
                             const ToleranceSchedule& tolerance, const ContactResidual& first,
                             SavedImpulses& saved) {
  saved.save(problem);
  for (int round = 0; round < parameters.relaxation_rounds; ++round) relax(problem);
  const ContactResidual relaxed = problem.residual(parameters);
  if (tolerance.excess_m_s(relaxed) < tolerance.excess_m_s(first)) return relaxed;
  saved.restore(problem);
  problem.update_velocities();
  return first;
}

}  // namespace aprsim::physics
