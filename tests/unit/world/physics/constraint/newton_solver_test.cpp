#include "world/physics/constraint/newton_solver.hpp"

#include <gtest/gtest.h>

#include "tests/unit/world/physics/constraint/random_problems.hpp"

namespace aprsim::physics {
namespace {

constexpr double kTolerance_m_s = 1e-9;
const ContactSolverParameters kNewtonParameters;

void begin(const Problem& problem, SolverBench& bench) {
  problem.state_to(bench);
  bench.complete(kNewtonParameters);
  bench.set_proximal_weight(kNewtonParameters.max_proximal_weight, kNewtonParameters);
  bench.update_velocities();
  bench.update_proximal_point();
}

TEST(NewtonSolver, FindsVelocitiesThatFollowFromTheirImpulses) {
  RandomProblems problems(31);
  NewtonSolver newton;
  int solved = 0;
  constexpr int kProblems = 100;
  for (int round = 0; round < kProblems; ++round) {
    SolverBench bench;
    begin(problems.next(), bench);
    newton.prepare(bench);
    const auto result = newton.solve(bench, kNewtonParameters,
                                     {.tolerance_m_s = kTolerance_m_s,
                                      .max_steps = kNewtonParameters.max_newton_steps,
                                      .may_hold_slip = true});
    if (!result.solved) continue;
    ++solved;
    std::vector<Twist> twists;
    for (const int body : bench.moving()) twists.push_back(bench.twist(body));
    bench.update_velocities();
    for (std::size_t i = 0; i < twists.size(); ++i) {
      const Twist& expected = bench.twist(bench.moving()[i]);
      ASSERT_LT((twists[i].v - expected.v).norm(), 2 * kTolerance_m_s);
      ASSERT_LT(kNewtonParameters.angular_lever_m * (twists[i].omega - expected.omega).norm(),
                2 * kTolerance_m_s);
    }
  }
  EXPECT_GE(solved, kProblems * 90 / 100);
}

TEST(NewtonSolver, KeepsItsLimits) {
  RandomProblems problems(37);
  NewtonSolver newton;
  int failed = 0;
  for (int round = 0; round < 100; ++round) {
    const Problem problem = problems.next();
    for (const int max_steps : {1, 3, 200}) {
      SolverBench bench;
      begin(problem, bench);
      newton.prepare(bench);
      const auto result =
          newton.solve(bench, kNewtonParameters,
                       {.tolerance_m_s = 0, .max_steps = max_steps, .may_hold_slip = false});
      EXPECT_LE(result.steps, std::min(max_steps, kNewtonParameters.max_subproblem_newton_steps));
      EXPECT_FALSE(result.held_slip);
      failed += !result.solved;
    }
  }
  // A tolerance of 0 is hardly ever reached.
  EXPECT_GT(failed, 0);
}

}  // namespace
}  // namespace aprsim::physics
