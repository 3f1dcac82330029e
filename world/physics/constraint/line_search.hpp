#pragma once

#include <cmath>

#include "world/physics/constraint/contact_solver_parameters.hpp"

namespace aprsim::physics {

/// Minimum of a convex function along a direction: the zero of its rising slope by regula falsi
/// (Illinois), or the full step 1 where the slope is small enough or negative there. `slope(step)`
/// is the derivative, negative at 0.
template <typename Slope>
[[nodiscard]] double search_line(const ContactSolverParameters& parameters, const Slope& slope) {
  double lower = 0, slope_lower = slope(0), upper = 1, slope_upper = slope(1);
  const double initial = std::abs(slope_lower);
  // The full step, as far from the solution as near it.
  if (std::abs(slope_upper) <= parameters.full_step_slope * initial || slope_upper <= 0) return 1;
  // The bracket shrinks from both sides: an end that stays counts half.
  for (int i = 0; i < parameters.max_line_search_steps; ++i) {
    const double middle = (lower * slope_upper - upper * slope_lower) / (slope_upper - slope_lower);
    const double slope_middle = slope(middle);
    if (std::abs(slope_middle) <= parameters.line_search_slope * initial) return middle;
    if (slope_middle < 0) {
      lower = middle;
      slope_lower = slope_middle;
      slope_upper *= 0.5;
    } else {
      upper = middle;
      slope_upper = slope_middle;
      slope_lower *= 0.5;
    }
  }
  return lower > 0 ? lower : upper;
}

}  // namespace aprsim::physics
