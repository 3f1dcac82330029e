#include "world/physics/constraint/contact_solver_statistics.hpp"

#include <gtest/gtest.h>

#include "tests/unit/world/physics/constraint/random_problems.hpp"

namespace aprsim::physics {
namespace {

using Statistics = ContactSolverStatistics;

TEST(ContactSolverStatistics, CountsWhatItCannotHold) {
  Statistics statistics;
  for (int i = 0; i <= Statistics::kCapacity; ++i) statistics.record({.newton_steps = i});
  EXPECT_EQ(statistics.outer_iteration_count(), Statistics::kCapacity + 1);
  ASSERT_EQ(statistics.outer_iterations().size(), std::size_t{Statistics::kCapacity});
  EXPECT_EQ(statistics.outer_iterations().back().newton_steps, Statistics::kCapacity - 1);
  statistics.clear();
  EXPECT_EQ(statistics.outer_iteration_count(), 0);
  EXPECT_TRUE(statistics.outer_iterations().empty());
}

TEST(ContactSolverStatistics, AgreeWithTheOutcome) {
  const ContactSolverParameters& parameters = kStrict;
  RandomProblems problems(13);
  SolverBench bench;
  int rejected = 0;
  for (int round = 0; round < 200; ++round) {
    const ContactSolver::Outcome outcome = problems.next().solve(bench);
    const Statistics& statistics = bench.solver.statistics();
    int newton_steps = 0;
    double residual_m_s = statistics.start_residual_m_s;
    for (const auto& iteration : statistics.outer_iterations()) {
      newton_steps += iteration.newton_steps;
      rejected += !iteration.accepted;
      EXPECT_TRUE(iteration.accepted || iteration.residual_m_s == residual_m_s);
      residual_m_s = iteration.residual_m_s;
      EXPECT_GE(iteration.newton_steps, 1);
      EXPECT_GE(iteration.proximal_weight, parameters.min_proximal_weight);
      EXPECT_LE(iteration.proximal_weight, parameters.max_proximal_weight);
      EXPECT_GT(iteration.shortest_step, 0);
      EXPECT_LE(iteration.shortest_step, 1);
    }
    EXPECT_EQ(newton_steps, outcome.newton_steps);
    EXPECT_LE(statistics.start_residual_m_s, statistics.initial_residual_m_s);
    if (!outcome.converged || statistics.outer_iterations().empty()) continue;
    const auto& last = statistics.outer_iterations().back();
    EXPECT_EQ(last.residual_m_s, outcome.residual_m_s);
    EXPECT_LE(last.residual_m_s, last.tolerance_m_s);
  }
  EXPECT_GT(rejected, 0);
}

TEST(ContactSolverStatistics, TheResidualFalls) {
  RandomProblems problems(19);
  SolverBench bench;
  int accepted = 0, fell = 0;
  for (int round = 0; round < 200; ++round) {
    problems.next().solve(bench);
    double before_m_s = bench.solver.statistics().start_residual_m_s;
    for (const auto& iteration : bench.solver.statistics().outer_iterations()) {
      if (!iteration.accepted) continue;
      ++accepted;
      fell += iteration.residual_m_s < before_m_s;
      before_m_s = iteration.residual_m_s;
    }
  }
  // Contacts that change between sticking, sliding and open may raise it for an iteration.
  EXPECT_GE(fell, accepted * 80 / 100);
}

TEST(ContactSolverStatistics, AWarmStartThatFitsTakesNoIteration) {
  RandomProblems problems(3);
  SolverBench bench;
  Problem problem = problems.next();
  ASSERT_TRUE(problem.solve(bench).converged);
  ASSERT_FALSE(bench.solver.statistics().outer_iterations().empty());
  for (std::size_t k = 0; k < problem.contacts.size(); ++k) {
    problem.contacts[k].impulse_ns.last = bench.contact_impulse_ns(static_cast<int>(k));
  }
  const ContactSolver::Outcome outcome = problem.solve(bench);
  EXPECT_TRUE(outcome.warm_start_fits);
  EXPECT_EQ(outcome.newton_steps, 0);
  EXPECT_TRUE(bench.solver.statistics().outer_iterations().empty());
  EXPECT_EQ(bench.solver.statistics().start_residual_m_s, outcome.residual_m_s);
}

}  // namespace
}  // namespace aprsim::physics
