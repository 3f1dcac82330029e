#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <span>

namespace aprsim::physics {

/// The course of one solve, by outer iteration. Its size is fixed, so that recording never
/// allocates.
class ContactSolverStatistics {
 public:
  /// Outer iterations that are recorded: as many as the default limit of Newton steps allows.
  static constexpr int kCapacity = 200;

  /// Solution of one subproblem.
  struct OuterIteration {
    double proximal_weight = 0;
    /// After it; the one before it where it was rejected.
    double residual_m_s = 0;
    double tolerance_m_s = 0;   ///< of the schedule, after it
    int newton_steps = 0;       ///< matrices factorised
    int line_search_steps = 0;  ///< evaluations of the merit or the slope
    double shortest_step = 1;   ///< line search: shortest accepted step, in Newton directions
    bool held_slip = false;     ///< the convex subproblem took over
    bool accepted = true;       ///< false: back to the proximal point, with a larger weight
  };

  double initial_residual_m_s = 0;  ///< of the better warm start
  bool relaxed = false;             ///< by rounds of Gauss-Seidel, after an impact
  double start_residual_m_s = 0;    ///< where the outer iteration starts

  /// Forgets the last solve.
  void clear() {
    initial_residual_m_s = start_residual_m_s = 0;
    relaxed = false;
    count_ = 0;
  }
  void record(const OuterIteration& iteration) {
    if (count_ < kCapacity) iterations_[static_cast<std::size_t>(count_)] = iteration;
    ++count_;
  }
  /// In order; the first kCapacity of them.
  [[nodiscard]] std::span<const OuterIteration> outer_iterations() const {
    return {iterations_.data(), static_cast<std::size_t>(count_ < kCapacity ? count_ : kCapacity)};
  }
  /// Number of all outer iterations.
  [[nodiscard]] int outer_iteration_count() const { return count_; }

 private:
  std::array<OuterIteration, kCapacity> iterations_;
  int count_ = 0;
};

/// Reads the course of a solve.
using SolverObserver = std::function<void(const ContactSolverStatistics&)>;

}  // namespace aprsim::physics
