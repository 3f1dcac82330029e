#include "world/physics/constraint/newton_solver.hpp"

#include <algorithm>
#include <cmath>

#include "world/base/simd/vector6.hpp"
#include "world/base/simd/vector_clones.hpp"
#include "world/physics/constraint/line_search.hpp"

namespace aprsim::physics {

/// The structure depends on the pairs only, and so is analysed once for all subproblems of a step.
void NewtonSolver::prepare(ContactProblem& problem) {
  matrix_.analyse(problem);
  gradient_.resize(problem.moving().size());
  direction_.resize(problem.moving().size());
}

NewtonSolver::Result NewtonSolver::solve(ContactProblem& problem,
                                         const ContactSolverParameters& parameters,
                                         const Limits& limits) {
  Result result;
  // Each subproblem first lets the De Saxce correction follow the slip: Newton then converges
  // quadratically also where contacts slide.
  newton_on_slip_ = true;
  // The tolerance is a velocity, so that light and heavy bodies are solved equally well.
  Gradient gradient = evaluate(problem, parameters.angular_lever_m);
  // Newton iteration. At least one step, for the proximal point has moved.
  while (result.directions < parameters.max_subproblem_newton_steps &&
         result.steps < limits.max_steps) {
    if (gradient.speed_m_s <= limits.tolerance_m_s && result.directions > 0) break;
    // Newton direction: (M + J' G J) d = -g.
    ++result.steps;
    if (!find_direction(problem)) {
      result.solved = false;
      break;
    }
    ++result.directions;
    evaluate_rates(problem);
    if (newton_on_slip_) {
      // No convex function belongs to the unsymmetric problem. The gradient's norm in the metric
      // M^-1 is the merit instead (Dennis & Schnabel 1996, sec. 6.5).
      // Globalisation of the unsymmetric problem: backtracking on g' M^-1 g.
      if (backtrack(problem, parameters, gradient, result)) continue;
      if (!limits.may_hold_slip) {
        result.solved = false;
        break;
      }
      // With a held correction the subproblem is the one of SAP (Castro et al. 2022), and an outer
      // iteration is a fixed-point step on the slip (Cadoux 2009; Acary et al. 2011).
      // Fallback: from here on the convex subproblem, with the correction of these velocities.
      newton_on_slip_ = false;
      result.held_slip = true;
      problem.update_de_saxce_correction();
    } else {
      // Globalisation of the convex subproblem: the minimum along the direction.
      search_minimum(problem, parameters, result);
    }
    gradient = evaluate(problem, parameters.angular_lever_m);
  }
  if (result.directions >= parameters.max_subproblem_newton_steps) result.solved = false;
  return result;
}

// ---- the gradient

APRSIM_VECTOR_CLONES NewtonSolver::Gradient NewtonSolver::evaluate(ContactProblem& problem,
                                                                   double angular_lever_m) {
  set_momentum_change(problem);
  subtract_impulses(problem);
  return measure(problem, angular_lever_m);
}

/// g = M (V - V_free).
inline void NewtonSolver::set_momentum_change(const ContactProblem& problem) {
  for (const int i : problem.moving()) {
    const SolverBody& body = problem.at(i);
    const Eigen::Vector3d p = body.kg * (body.twist.v - body.free_twist.v);
    const Eigen::Vector3d m = body.inertia * (body.twist.omega - body.free_twist.omega);
    const Vector6 g = {Vec4d{p.x(), p.y(), p.z(), m.x()}, Vector6::Pair{m.y(), m.z()}};
    g.store(gradient_[index(body.unknown)].data());
  }
}

/// g -= J' gamma(v_c).
inline void NewtonSolver::subtract_impulses(ContactProblem& problem) {
  const auto add = [&](int body, double sign, const Vector6& impulse) {
    const int unknown = problem.unknown_of(body);
    if (unknown < 0) return;
    double* g = gradient_[index(unknown)].data();
    (Vector6::load(g) + sign * impulse).store(g);
  };
  // gamma(v_c) is the projection of the regularized impulse onto its set: bounds of a row, cone of
  // a contact (Todorov 2014; Castro et al. 2022).
  for (SolverRow& row : problem.rows()) row.evaluate_impulse(0);
  for (const SolverRow& row : problem.rows()) {
    for (const SolverRow::Side* side : {&row.a, &row.b}) {
      const Eigen::Vector3d &v = side->linear, &w = side->angular;
      add(side->body, -row.gamma, {Vec4d{v.x(), v.y(), v.z(), w.x()}, Vector6::Pair{w.y(), w.z()}});
    }
  }
  for (ContactPack& pack : problem.packs()) {
    pack.evaluate_impulses(pack.v_c, pack.torsion.omega_c, newton_on_slip_);
    if (pack.is_idle()) continue;
    const ContactPack::BodyImpulses impulses = pack.body_impulses();
    add(pack.a, -1, impulses.on_a);
    add(pack.b, 1, impulses.against_b);
  }
}

inline NewtonSolver::Gradient NewtonSolver::measure(const ContactProblem& problem,
                                                    double angular_lever_m) const {
  Gradient out;
  double speed2 = 0;
  for (const int i : problem.moving()) {
    const SolverBody& body = problem.at(i);
    const BlockVector& g = gradient_[index(body.unknown)];
    // M^-1 g is the error of momentum balance as a velocity; rotations count at the lever of a
    // typical part.
    const Eigen::Vector3d dv = body.inverse_kg * g.head<3>(),
                          dw = body.inverse_inertia * g.tail<3>();
    out.merit += g.head<3>().dot(dv) + g.tail<3>().dot(dw);
    speed2 =
        std::max({speed2, dv.squaredNorm(), angular_lever_m * angular_lever_m * dw.squaredNorm()});
  }
  out.speed_m_s = std::sqrt(speed2);
  return out;
}

// ---- the direction

APRSIM_VECTOR_CLONES bool NewtonSolver::find_direction(ContactProblem& problem) {
  matrix_.assemble(problem);
  for (std::size_t i = 0; i < gradient_.size(); ++i) direction_[i] = -gradient_[i];
  return matrix_.solve(direction_);
}

/// delta_v_c = J d.
APRSIM_VECTOR_CLONES void NewtonSolver::evaluate_rates(ContactProblem& problem) const {
  const auto direction_of = [&](int body) -> const BlockVector* {
    const int unknown = problem.unknown_of(body);
    return unknown < 0 ? nullptr : &direction_[index(unknown)];
  };
  for (SolverRow& row : problem.rows()) {
    row.delta_v_c = 0;
    for (const SolverRow::Side* side : {&row.a, &row.b}) {
      if (const BlockVector* d = direction_of(side->body)) {
        row.delta_v_c += side->linear.dot(d->head<3>()) + side->angular.dot(d->tail<3>());
      }
    }
  }
  for (ContactPack& pack : problem.packs()) {
    pack.evaluate_rates(direction_of(pack.a), direction_of(pack.b));
  }
}

/// V += step d, v_c += step J d.
APRSIM_VECTOR_CLONES void NewtonSolver::move_along(ContactProblem& problem, double step) const {
  // The constraint velocities are linear in V, so a step needs no new Jacobian products.
  for (const int i : problem.moving()) {
    SolverBody& body = problem.at(i);
    const BlockVector& d = direction_[index(body.unknown)];
    body.twist.v += step * d.head<3>();
    body.twist.omega += step * d.tail<3>();
  }
  for (SolverRow& row : problem.rows()) row.v_c += step * row.delta_v_c;
  for (ContactPack& pack : problem.packs()) pack.move_along(step);
}

// ---- the step length

/// Takes the longest of the steps 1, 1/2, 1/4, ... that reduces the merit enough (Armijo). False if
/// there is none; the velocities are then unchanged.
bool NewtonSolver::backtrack(ContactProblem& problem, const ContactSolverParameters& parameters,
                             Gradient& gradient, Result& result) {
  // Moves are made from where the last trial ended; this costs one update per trial.
  double step = 1, moved = 0;
  for (int i = 0; i < parameters.max_backtracking_steps; ++i, step *= 0.5) {
    move_along(problem, step - moved);
    moved = step;
    const Gradient next = evaluate(problem, parameters.angular_lever_m);
    ++result.line_search_steps;
    if (next.merit <= (1 - parameters.sufficient_decrease * step) * gradient.merit) {
      gradient = next;
      result.shortest_step = std::min(result.shortest_step, step);
      return true;
    }
  }
  move_along(problem, -moved);
  return false;
}

void NewtonSolver::search_minimum(ContactProblem& problem,
                                  const ContactSolverParameters& parameters, Result& result) const {
  const double step = search_line(parameters, [&](double along) {
    ++result.line_search_steps;
    return slope(problem, along);
  });
  result.shortest_step = std::min(result.shortest_step, step);
  move_along(problem, step);
}

/// Derivative of the convex function along the direction: d' g(V + step d).
double NewtonSolver::slope(ContactProblem& problem, double step) const {
  double sum = 0;
  for (const int i : problem.moving()) {
    const SolverBody& body = problem.at(i);
    const BlockVector& d = direction_[index(body.unknown)];
    // The slope costs O(n), since d' M d and J d are known (as in SAP, Castro et al. 2022).
    const Eigen::Vector3d dv = body.twist.v - body.free_twist.v + step * d.head<3>();
    const Eigen::Vector3d dw = body.twist.omega - body.free_twist.omega + step * d.tail<3>();
    sum += body.kg * d.head<3>().dot(dv) + d.tail<3>().dot(body.inertia * dw);
  }
  evaluate_impulses(problem, step);
  for (const SolverRow& row : problem.rows()) sum -= row.delta_v_c * row.gamma;
  for (const ContactPack& pack : problem.packs()) sum -= pack.impulse_slope();
  return sum;
}

/// gamma(v_c + step delta_v_c), and its derivatives.
APRSIM_VECTOR_CLONES void NewtonSolver::evaluate_impulses(ContactProblem& problem,
                                                          double step) const {
  for (SolverRow& row : problem.rows()) row.evaluate_impulse(step);
  const Vec4d share = broadcast(step);
  for (ContactPack& pack : problem.packs()) {
    pack.evaluate_impulses(pack.v_c + share * pack.delta_v_c,
                           pack.torsion.omega_c + share * pack.torsion.delta_omega_c,
                           newton_on_slip_);
  }
}

}  // namespace aprsim::physics
