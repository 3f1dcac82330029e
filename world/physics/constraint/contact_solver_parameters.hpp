#pragma once

namespace aprsim::physics {

/// All parameters of ContactSolver. Speeds are residuals of constraint velocities; angular
/// velocities count at `angular_lever_m`. Weights and regularizations are relative to the Delassus
/// diagonal W = diag(J M^-1 J'), and so independent of mass.
///
/// Values without a derivation are empirical: they change the number of Newton steps, and the
/// solution within its tolerance only.
struct ContactSolverParameters {
  // ---- tolerances

  /// Residual that is accepted [m/s]. In a step of 1 ms it moves nothing by more than 10 pm.
  double tolerance_m_s = 1e-8;
  /// Residual that is accepted of contacts of unactuated bodies, if it is greater [m/s]. Scenes set
  /// it (`physics.residual_m_s`): larger values save Newton steps, and let such bodies drift.
  double relaxed_tolerance_m_s = 1e-8;
  /// Upper bound of the tolerance schedule [m/s]. In a step of 1 ms it moves nothing by more than
  /// 30 nm, less than the slop of resting contacts (2 um).
  double max_tolerance_m_s = 3e-5;
  /// Newton steps at the plain tolerance; then the schedule relaxes it.
  double schedule_start_newton_steps = 20;
  /// Newton steps in which the schedule relaxes the tolerance tenfold. Smaller values end slow
  /// solves sooner, with larger residuals.
  double schedule_decade_newton_steps = 12;
  /// Bodies slower than this are at rest, if no row acts [m/s].
  double rest_speed_m_s = 1e-4;
  /// Factor of the tolerance of bodies at rest. Without it the residuals of very many steps would
  /// add energy; it costs a Newton step now and then.
  double rest_tolerance_factor = 0.1;
  /// Lever at which angular velocities count as velocities [m]: the order of the parts' radii.
  double angular_lever_m = 0.01;
  /// Share of a contact's sliding speed that its residual may have besides. Without it fast sliding
  /// would be solved to more relative digits than slow sliding.
  double sliding_relative_tolerance = 1e-6;

  // ---- regularization

  /// Compliance of friction, relative to W. Sticking contacts creep by 1e-9 of the velocity that
  /// friction prevents; it makes tangential impulses unique where several contacts share them.
  double friction_regularization = 1e-9;

  // ---- proximal weight: regularization of the proximal term, relative to W

  /// Initial weight per first residual [s/m]: a residual of 0.1 mm/s starts at 0.01. Far from the
  /// solution a greater weight keeps the first subproblems easy.
  double initial_proximal_weight_s_m = 100;
  /// Lower bound of the initial weight.
  double min_initial_proximal_weight = 3e-3;
  /// Bounds of the weight. The lower one limits the condition of Newton's matrix; at the upper one
  /// the convex subproblem is the fallback, which a line search always solves.
  double min_proximal_weight = 1e-8, max_proximal_weight = 1e-1;
  /// Factor of the weight after an outer iteration that needed few Newton steps. A smaller weight
  /// contracts the residual more in an outer iteration, and makes its subproblem harder.
  double proximal_weight_decrease = 0.1;
  /// The same after any subproblem of this solve has failed.
  double cautious_proximal_weight_decrease = 0.2;
  /// Factor of the weight after a subproblem that failed.
  double proximal_weight_increase = 5;
  /// The weight decreases after subproblems of at most this number of Newton steps.
  int easy_subproblem_newton_steps = 5;
  /// The weight stays where an outer iteration leaves at most this share of the residual.
  double fast_contraction = 3e-3;

  // ---- Newton's method in a subproblem

  /// Newton steps of all subproblems together; then the best iterate is taken, as not converged.
  int max_newton_steps = 200;
  /// Newton steps of one subproblem; then it has failed.
  int max_subproblem_newton_steps = 12;
  /// Share of the last residual to which a subproblem is solved. The proximal method converges
  /// with inexact solutions, too (Rockafellar 1976).
  double newton_relative_tolerance = 1e-2;
  /// Share of the tolerance to which a subproblem is solved at most.
  double newton_tolerance_share = 0.1;
  /// Steps 1, 1/2, 1/4, ... that backtracking tries; then the subproblem has failed.
  int max_backtracking_steps = 6;
  /// Share of the merit that a full step must remove, shorter ones in proportion (Armijo).
  double sufficient_decrease = 0.02;
  /// Regula falsi steps of the line search of the convex subproblem.
  int max_line_search_steps = 20;
  /// Share of the initial slope at which the line search ends. Smaller values evaluate the slope
  /// more often for a more exact minimum.
  double line_search_slope = 0.1;
  /// Share of the initial slope at which the full step is accepted.
  double full_step_slope = 0.2;

  // ---- relaxation after an impact

  /// Warm starts with a greater residual are relaxed first, if no row acts [m/s]: an impact changes
  /// the set of bearing contacts. Below it the warm start is close, and Newton's method follows.
  double impact_residual_m_s = 1e-4;
  /// Rounds of nonlinear Gauss-Seidel. They find cheaply which contacts bear and which slip; it
  /// converges linearly, so that further rounds gain less than Newton steps.
  int relaxation_rounds = 10;

  // ---- large islands: what their solves do otherwise (see for_large_island)

  /// Islands of more bodies are large. The greatest shipped cells stay below it.
  int max_small_island_bodies = 64;
  /// Residual that is accepted where no row acts and bodies move [m/s]: 10 nm in a step.
  double large_island_tolerance_m_s = 1e-5;
  /// Newton steps of all subproblems together: half as many, for each costs more.
  int large_island_max_newton_steps = 100;
  /// Rounds of Gauss-Seidel after an impact. A round costs a tenth of a Newton step there.
  int large_island_relaxation_rounds = 60;
  /// Counterparts of `proximal_weight_decrease`, `cautious_proximal_weight_decrease`,
  /// `proximal_weight_increase` and `fast_contraction`. With many contacts a small weight fails
  /// more often, and a failure costs more than an outer iteration.
  double large_island_weight_decrease = 0.3, large_island_cautious_weight_decrease = 0.5;
  double large_island_weight_increase = 2, large_island_fast_contraction = 0.3;

  // ---- regions of large islands

  /// Contacts with at least this share of the largest residual are in a region.
  double region_threshold = 0.1;
  /// Regions of more than this share of all bodies are left to the Newton steps of the whole.
  double max_region_share = 0.4;
  /// Rounds of solving regions between two outer iterations.
  int max_region_rounds = 16;
  /// A round that leaves more of the residual than this share is slow; the second slow one is the
  /// last.
  double slow_region_round = 0.5;
  /// A round that leaves more of the residual than this is undone. Below it residuals may grow for
  /// a round, because they move to neighbours.
  double max_region_growth = 20;
  /// Share of the residual to which a region is solved, and of the tolerance at most.
  double region_relative_tolerance = 0.05, region_tolerance_share = 0.3;
  /// Newton steps of one region.
  int max_region_newton_steps = 60;
};

/// The parameters with those of large islands in their places. `strict`: a row acts, or all bodies
/// rest, and the tolerance stays.
[[nodiscard]] inline ContactSolverParameters for_large_island(const ContactSolverParameters& in,
                                                              bool strict) {
  ContactSolverParameters out = in;
  if (!strict && out.tolerance_m_s < in.large_island_tolerance_m_s) {
    out.tolerance_m_s = in.large_island_tolerance_m_s;
    if (out.relaxed_tolerance_m_s < out.tolerance_m_s) {
      out.relaxed_tolerance_m_s = out.tolerance_m_s;
    }
  }
  if (out.max_newton_steps > in.large_island_max_newton_steps) {
    out.max_newton_steps = in.large_island_max_newton_steps;
  }
  out.relaxation_rounds = in.large_island_relaxation_rounds;
  out.proximal_weight_decrease = in.large_island_weight_decrease;
  out.cautious_proximal_weight_decrease = in.large_island_cautious_weight_decrease;
  out.proximal_weight_increase = in.large_island_weight_increase;
  out.fast_contraction = in.large_island_fast_contraction;
  return out;
}

}  // namespace aprsim::physics
