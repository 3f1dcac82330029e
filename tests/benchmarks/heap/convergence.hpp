#pragma once

#include <vector>

#include "tests/benchmarks/support/plot.hpp"
#include "tests/benchmarks/support/table.hpp"
#include "world/physics/constraint/contact_solver_statistics.hpp"

namespace aprsim::bench {

/// Residuals of the contact solver over its outer iterations, of many solves. Solves whose warm
/// start fits have none and do not count.
class Convergence {
 public:
  void add(const physics::ContactSolverStatistics& statistics);

  /// A row an iteration; 0 is where the outer iteration starts.
  [[nodiscard]] Table table() const;
  [[nodiscard]] Plot plot() const;

 private:
  /// The same iteration of all solves that have come so far.
  struct Iteration {
    std::vector<double> residuals_m_s, proximal_weights, newton_steps;
    int rejected = 0;
  };
  Iteration& at(std::size_t iteration);

  std::vector<Iteration> iterations_;
  std::vector<double> longest_m_s_;  ///< residuals of the solve with the most iterations
};

}  // namespace aprsim::bench
