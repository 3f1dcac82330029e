#pragma once

#include <vector>

#include "world/physics/constraint/contact_problem.hpp"
#include "world/physics/constraint/contact_solver_parameters.hpp"
#include "world/physics/constraint/contact_solver_statistics.hpp"
#include "world/physics/constraint/proximal_point.hpp"
#include "world/physics/constraint/saved_impulses.hpp"
#include "world/physics/constraint/tolerance_schedule.hpp"

namespace aprsim::physics {

/// Solves those regions of a large problem that are not solved yet. A region is made of the
/// contacts with a large residual and their neighbours; its contacts are solved together, while all
/// others keep their impulses (Schwarz's alternating method on the impulses; block coordinate
/// descent of the dual problem). Residuals then move to the region's border and fall from round to
/// round. In a heap few contacts hold up Newton's method, and so the cost of their solution does
/// not grow with the heap. No call allocates after warm-up; the order is fixed by body numbers.
class RegionSolver {
 public:
  struct Result {
    ContactResidual residual;
    int regions = 0;          ///< solved; 0 = the problem is unchanged
    double newton_steps = 0;  ///< each by its region's share of all bodies
  };

  /// From the problem's impulses, with the velocities that they cause and the residual `first`, to
  /// at most `tolerance_m_s`. Velocities at the end are those of the impulses.
  [[nodiscard]] Result solve(ContactProblem& problem, const ContactSolverParameters& parameters,
                             const ToleranceSchedule& tolerance, double tolerance_m_s,
                             const ContactResidual& first);

 private:
  [[nodiscard]] int mark_bodies(const ContactProblem& problem,
                                const ContactSolverParameters& parameters,
                                const ToleranceSchedule& tolerance, double above_m_s);
  void mark_neighbours(const ContactProblem& problem);
  void find_regions(const ContactProblem& problem);
  [[nodiscard]] int region_of(int unknown);
  /// Number of its bodies times its Newton steps.
  [[nodiscard]] double solve_region(ContactProblem& problem,
                                    const ContactSolverParameters& parameters, int region);
  [[nodiscard]] bool is_inside(const ContactProblem& problem, int body, int region);
  [[nodiscard]] bool is_inside(const ContactProblem& problem, int a, int b, int region);
  [[nodiscard]] int copy_body(const ContactProblem& problem, int body);
  void copy_region(const ContactProblem& problem, int region);
  void take_impulses(ContactProblem& problem) const;
  [[nodiscard]] static std::size_t index(int i) { return static_cast<std::size_t>(i); }

  ContactProblem part_;
  ProximalPoint proximal_point_;
  SavedImpulses best_, before_;
  ContactSolverStatistics statistics_;     // of a region; not reported
  std::vector<char> marked_, seeds_;       // by unknown: in a region
  std::vector<int> parent_;                // by unknown: union-find
  std::vector<int> number_;                // by body: in part_, or -1
  std::vector<std::size_t> rows_, packs_;  // of part_: their numbers in the problem
};

}  // namespace aprsim::physics
