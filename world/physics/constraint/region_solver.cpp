#include "world/physics/constraint/region_solver.hpp"

#include <algorithm>
#include <tuple>

namespace aprsim::physics {

RegionSolver::Result RegionSolver::solve(ContactProblem& problem,
                                         const ContactSolverParameters& parameters,
                                         const ToleranceSchedule& tolerance, double tolerance_m_s,
                                         const ContactResidual& first) {
  Result out{.residual = first};
  const int bodies = static_cast<int>(problem.moving().size());
  int slow_rounds = 0;
  for (int round = 0; round < parameters.max_region_rounds && slow_rounds < 2; ++round) {
    const double before_m_s = tolerance.excess_m_s(out.residual);
    if (before_m_s <= tolerance_m_s) break;
    // The worst places first: what they change is seen before the others are solved.
    const double above_m_s = std::max(tolerance_m_s, parameters.region_threshold * before_m_s);
    const int marked = mark_bodies(problem, parameters, tolerance, above_m_s);
    if (marked > parameters.max_region_share * bodies) break;
    find_regions(problem);
    before_.save(problem);
    ContactSolverParameters own = parameters;
    own.tolerance_m_s = std::max(parameters.region_tolerance_share * tolerance_m_s,
                                 parameters.region_relative_tolerance * before_m_s);
    own.relaxed_tolerance_m_s = own.tolerance_m_s + std::max(0.0, parameters.relaxed_tolerance_m_s -
                                                                      parameters.tolerance_m_s);
    own.max_newton_steps = parameters.max_region_newton_steps;
    for (int i = 0; i < bodies; ++i) {
      if (marked_[index(i)] == 0 || region_of(i) != i) continue;
      out.newton_steps += solve_region(problem, own, i) / bodies;
      ++out.regions;
    }
    const ContactResidual now = problem.residual(parameters);
    const double now_m_s = tolerance.excess_m_s(now);
    if (now_m_s >= parameters.max_region_growth * before_m_s) {
      before_.restore(problem);
      problem.update_velocities();
      break;
    }
    out.residual = now;
    if (now_m_s > parameters.slow_region_round * before_m_s) ++slow_rounds;
  }
  return out;
}

/// The bodies of contacts with a greater residual, and their neighbours. Returns their number.
int RegionSolver::mark_bodies(const ContactProblem& problem,
                              const ContactSolverParameters& parameters,
                              const ToleranceSchedule& tolerance, double above_m_s) {
  marked_.assign(problem.moving().size(), 0);
  const auto mark = [&](int a, int b) {
    for (const int body : {a, b}) {
      const int unknown = problem.unknown_of(body);
      if (unknown >= 0) marked_[index(unknown)] = 1;
    }
  };
  for (const SolverRow& row : problem.rows()) {
    if (row.residual(parameters.angular_lever_m) > above_m_s) mark(row.a.body, row.b.body);
  }
  for (const ContactPack& pack : problem.packs()) {
    ContactResidual residual;
    (pack.actuated ? residual.actuated_m_s : residual.relaxed_m_s) = pack.residual(parameters);
    if (tolerance.excess_m_s(residual) > above_m_s) mark(pack.a, pack.b);
  }
  mark_neighbours(problem);
  return static_cast<int>(std::count(marked_.begin(), marked_.end(), 1));
}

/// Across contacts that bear or approach.
void RegionSolver::mark_neighbours(const ContactProblem& problem) {
  seeds_ = marked_;
  const auto grow = [&](int a, int b) {
    const int i = problem.unknown_of(a), k = problem.unknown_of(b);
    if (i < 0 || k < 0) return;
    if (seeds_[index(i)] != 0) marked_[index(k)] = 1;
    if (seeds_[index(k)] != 0) marked_[index(i)] = 1;
  };
  for (const SolverRow& row : problem.rows()) grow(row.a.body, row.b.body);
  for (const ContactPack& pack : problem.packs()) {
    if (!pack.is_idle() || any(pack.v_c.x < 0)) grow(pack.a, pack.b);
  }
}

/// Marked bodies with a contact between them are in one region.
void RegionSolver::find_regions(const ContactProblem& problem) {
  parent_.resize(marked_.size());
  for (std::size_t i = 0; i < parent_.size(); ++i) parent_[i] = static_cast<int>(i);
  const auto unite = [&](int a, int b) {
    const int i = problem.unknown_of(a), k = problem.unknown_of(b);
    if (i < 0 || k < 0 || marked_[index(i)] == 0 || marked_[index(k)] == 0) return;
    const int ri = region_of(i), rk = region_of(k);
    parent_[index(std::max(ri, rk))] = std::min(ri, rk);
  };
  for (const SolverRow& row : problem.rows()) unite(row.a.body, row.b.body);
  for (const ContactPack& pack : problem.packs()) unite(pack.a, pack.b);
}

/// Path halving (Tarjan & van Leeuwen 1984).
int RegionSolver::region_of(int unknown) {
  while (parent_[index(unknown)] != unknown) {
    parent_[index(unknown)] = parent_[index(parent_[index(unknown)])];
    unknown = parent_[index(unknown)];
  }
  return unknown;
}

double RegionSolver::solve_region(ContactProblem& problem,
                                  const ContactSolverParameters& parameters, int region) {
  copy_region(problem, region);
  const ContactResidual first = part_.residual(parameters);
  statistics_.clear();
  const ContactSolverOutcome outcome = proximal_point_.solve(
      part_, parameters, ToleranceSchedule(parameters, false), first, best_, statistics_);
  take_impulses(problem);
  return static_cast<double>(outcome.newton_steps) * static_cast<double>(part_.moving().size());
}

bool RegionSolver::is_inside(const ContactProblem& problem, int body, int region) {
  const int unknown = problem.unknown_of(body);
  return unknown >= 0 && marked_[index(unknown)] != 0 && region_of(unknown) == region;
}

/// Whether a constraint between two bodies belongs to the region: none of them moves outside.
bool RegionSolver::is_inside(const ContactProblem& problem, int a, int b, int region) {
  const bool a_inside = is_inside(problem, a, region), b_inside = is_inside(problem, b, region);
  return (a_inside && (b_inside || problem.unknown_of(b) < 0)) ||
         (b_inside && problem.unknown_of(a) < 0);
}

int RegionSolver::copy_body(const ContactProblem& problem, int body) {
  if (body == ContactProblem::kFixed) return body;
  int& number = number_[index(body)];
  if (number < 0) number = part_.add_copy(problem.at(body));
  return number;
}

void RegionSolver::copy_region(const ContactProblem& problem, int region) {
  part_.clear();
  rows_.clear();
  packs_.clear();
  number_.assign(index(problem.body_count()), -1);
  for (const int body : problem.moving()) {
    if (is_inside(problem, body, region)) std::ignore = copy_body(problem, body);
  }
  for (std::size_t i = 0; i < problem.rows().size(); ++i) {
    const SolverRow& row = problem.rows()[i];
    if (!is_inside(problem, row.a.body, row.b.body, region)) continue;
    part_.add_copy(row, copy_body(problem, row.a.body), copy_body(problem, row.b.body));
    rows_.push_back(i);
  }
  for (std::size_t i = 0; i < problem.packs().size(); ++i) {
    const ContactPack& pack = problem.packs()[i];
    if (!is_inside(problem, pack.a, pack.b, region)) continue;
    part_.add_copy(pack, copy_body(problem, pack.a), copy_body(problem, pack.b));
    packs_.push_back(i);
  }
  part_.complete_part();
}

void RegionSolver::take_impulses(ContactProblem& problem) const {
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    problem.rows()[rows_[i]].gamma = part_.rows()[i].gamma;
  }
  for (std::size_t i = 0; i < packs_.size(); ++i) {
    problem.packs()[packs_[i]].gamma = part_.packs()[i].gamma;
    problem.packs()[packs_[i]].torsion.impulse = part_.packs()[i].torsion.impulse;
  }
}

}  // namespace aprsim::physics
