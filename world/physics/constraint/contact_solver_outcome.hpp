#pragma once

namespace aprsim::physics {

/// The end of a solve.
struct ContactSolverOutcome {
  bool converged = false;
  bool warm_start_fits = false;  ///< a warm start is the solution, and no row acts
  int newton_steps = 0;
  double residual_m_s = 0;
};

}  // namespace aprsim::physics
