#pragma once

#include "world/physics/constraint/contact_problem.hpp"
#include "world/physics/constraint/contact_solver_outcome.hpp"
#include "world/physics/constraint/contact_solver_parameters.hpp"
#include "world/physics/constraint/contact_solver_statistics.hpp"
#include "world/physics/constraint/newton_solver.hpp"
#include "world/physics/constraint/proximal_weight.hpp"
#include "world/physics/constraint/region_solver.hpp"
#include "world/physics/constraint/saved_impulses.hpp"
#include "world/physics/constraint/tolerance_schedule.hpp"

namespace aprsim::physics {

/// The outer iteration of islands of many bodies. It differs from ProximalPoint in two ways: before
/// each subproblem of the whole island RegionSolver solves those regions that are not solved yet,
/// and a subproblem that failed keeps its progress. The problem, and so the solution, is the same.
/// No call allocates after warm-up.
class LargeIslandSolver {
 public:
  /// As ProximalPoint::solve(). The outcome's Newton steps are those of the whole island, and those
  /// of regions by their share of the bodies.
  [[nodiscard]] ContactSolverOutcome solve(ContactProblem& problem,
                                           const ContactSolverParameters& parameters,
                                           const ToleranceSchedule& tolerance,
                                           const ContactResidual& first, SavedImpulses& best,
                                           ContactSolverStatistics& statistics);

 private:
  /// A solve's course.
  struct Course {
    ContactProblem& problem;
    const ContactSolverParameters& parameters;
    const ToleranceSchedule& tolerance;
    SavedImpulses& best;
    ContactResidual residual;
    double best_m_s = 0, last_m_s = 0;
    double newton_steps = 0;

    [[nodiscard]] int steps() const { return static_cast<int>(newton_steps); }
    [[nodiscard]] double excess_m_s() const { return tolerance.excess_m_s(residual); }
    [[nodiscard]] bool is_solved() const { return excess_m_s() <= tolerance.after(steps()); }
    void keep_best();
  };
  [[nodiscard]] bool solve_regions(Course& course);
  [[nodiscard]] NewtonSolver::Result solve_subproblem(Course& course, const ProximalWeight& weight);
  static void keep_progress(Course& course);

  NewtonSolver newton_;
  RegionSolver regions_;
};

}  // namespace aprsim::physics
