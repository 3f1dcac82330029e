#pragma once

#include <cstdint>
#include <vector>

#include "tests/benchmarks/heaps/heap_scene.hpp"

namespace aprsim::bench {

/// Cost and exactness of the steps of a heap.
struct HeapRun {
  std::vector<double> step_us;  ///< of the steps that are timed
  double newton_steps = 0;      ///< a timed step, mean over them
  double contacts = 0;          ///< the same
  double deepest_m = 0;         ///< of any step
  double unsolved = 0;          ///< timed steps' solves over their tolerance
  double worst_residual_m_s = 0;
  int lost = 0;
};

/// Runs a heap and times the steps from `from_s` to `to_s`.
[[nodiscard]] HeapRun run_heap(const HeapPlan& plan, double from_s, double to_s);

/// Exponent p of y = c x^p, by least squares of the logarithms.
[[nodiscard]] double growth_exponent(const std::vector<double>& x, const std::vector<double>& y);

}  // namespace aprsim::bench
