#pragma once

#include <vector>

#include "world/physics/constraint/block_lu.hpp"
#include "world/physics/constraint/contact_problem.hpp"
#include "world/physics/constraint/contact_solver_parameters.hpp"
#include "world/physics/constraint/newton_matrix.hpp"

namespace aprsim::physics {

/// Solves the subproblem of an outer iteration: for a fixed proximal point the impulses are
/// functions gamma(v_c) of the velocities, and a semismooth Newton method finds the velocities with
///
///     g(V) = M (V - V_free) - J' gamma(J V - target) = 0.
///
/// The De Saxce correction follows the velocities ("Newton on slip"). Where that makes no progress
/// and the caller allows it, the correction is held: the subproblem is then the minimum of a convex
/// function, which a line search always approaches (SAP: Castro et al. 2022). No call allocates
/// after warm-up.
class NewtonSolver {
 public:
  /// The end of a subproblem.
  struct Limits {
    double tolerance_m_s = 0;    ///< of the velocity that the gradient amounts to
    int max_steps = 0;           ///< what is left of all Newton steps
    bool may_hold_slip = false;  ///< the convex subproblem may take over; else it has failed
  };
  struct Result {
    bool solved = true;         ///< false: no progress, singular, or too many steps
    bool held_slip = false;     ///< the convex subproblem took over
    int steps = 0;              ///< systems factorised
    int directions = 0;         ///< of these the ones that were not singular
    int line_search_steps = 0;  ///< evaluations of the merit or the slope
    double shortest_step = 1;   ///< of all accepted ones, in Newton directions
  };

  /// Before the first subproblem of a problem: sets the structure of the matrix.
  void prepare(ContactProblem& problem);
  /// Moves the problem's velocities and impulses to the solution for its proximal point.
  Result solve(ContactProblem& problem, const ContactSolverParameters& parameters,
               const Limits& limits);

 private:
  /// Size of g.
  struct Gradient {
    double merit = 0;      ///< g' M^-1 g
    double speed_m_s = 0;  ///< largest velocity of M^-1 g
  };
  /// Impulses of the present velocities, and g.
  [[nodiscard]] Gradient evaluate(ContactProblem& problem, double angular_lever_m);
  void set_momentum_change(const ContactProblem& problem);
  void subtract_impulses(ContactProblem& problem);
  [[nodiscard]] Gradient measure(const ContactProblem& problem, double angular_lever_m) const;
  [[nodiscard]] bool find_direction(ContactProblem& problem);
  void evaluate_rates(ContactProblem& problem) const;
  void move_along(ContactProblem& problem, double step) const;
  [[nodiscard]] bool backtrack(ContactProblem& problem, const ContactSolverParameters& parameters,
                               Gradient& gradient, Result& result);
  void search_minimum(ContactProblem& problem, const ContactSolverParameters& parameters,
                      Result& result) const;
  [[nodiscard]] double slope(ContactProblem& problem, double step) const;
  void evaluate_impulses(ContactProblem& problem, double step) const;

  using BlockVector = BlockLu::BlockVector;
  [[nodiscard]] static std::size_t index(int i) { return static_cast<std::size_t>(i); }

  NewtonMatrix matrix_;
  std::vector<BlockVector> gradient_, direction_;
  bool newton_on_slip_ = false;  // else the De Saxce correction is held
};

}  // namespace aprsim::physics
