#pragma once

#include <algorithm>

#include "world/physics/constraint/contact_solver_parameters.hpp"

namespace aprsim::physics {

/// The weight of the proximal term from one outer iteration to the next. A small weight contracts
/// the residual fast, a large one makes the subproblem easy.
class ProximalWeight {
 public:
  ProximalWeight(const ContactSolverParameters& parameters, double first_residual_m_s)
      : parameters_(parameters),
        decrease_(parameters.proximal_weight_decrease),
        value_(std::clamp(parameters.initial_proximal_weight_s_m * first_residual_m_s,
                          parameters.min_initial_proximal_weight, parameters.max_proximal_weight)) {
  }

  [[nodiscard]] double value() const { return value_; }
  [[nodiscard]] bool is_max() const { return !(value_ < parameters_.max_proximal_weight); }

  /// After a subproblem that failed: a larger weight, and smaller decreases from there on.
  void increase() {
    value_ =
        std::min(parameters_.max_proximal_weight, parameters_.proximal_weight_increase * value_);
    decrease_ = parameters_.cautious_proximal_weight_decrease;
  }
  /// After an outer iteration: a smaller weight if its subproblem was easy and it contracted the
  /// residual slowly. `contraction`: the residual over the one before.
  void adapt(int newton_steps, double contraction) {
    const bool easy = newton_steps <= parameters_.easy_subproblem_newton_steps;
    if (!easy || !(contraction > parameters_.fast_contraction)) return;
    value_ = std::max(parameters_.min_proximal_weight, decrease_ * value_);
  }

 private:
  const ContactSolverParameters& parameters_;
  double decrease_, value_;
};

}  // namespace aprsim::physics
