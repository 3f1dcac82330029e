#include "world/physics/constraint/newton_matrix.hpp"

#include <gtest/gtest.h>

#include "tests/unit/world/physics/constraint/random_problems.hpp"

namespace aprsim::physics {
namespace {

using BlockVector = BlockLu::BlockVector;
using Vectors = std::vector<BlockVector>;

/// g = M (V - V_free) - J' gamma(J V - target) of all bodies, with V moved by `step` along d.
Vectors gradient(ContactProblem& problem, const Vectors& d, double step) {
  Vectors g;
  for (const int i : problem.moving()) {
    SolverBody& body = problem.at(i);
    const BlockVector& along = d[static_cast<std::size_t>(body.unknown)];
    body.twist.v += step * along.head<3>();
    body.twist.omega += step * along.tail<3>();
    BlockVector& out = g.emplace_back();
    out << body.kg * (body.twist.v - body.free_twist.v),
        body.inertia * (body.twist.omega - body.free_twist.omega);
  }
  problem.evaluate_constraint_velocities();
  const auto subtract = [&](int body, double sign, const Vector6& impulse) {
    const int unknown = problem.unknown_of(body);
    for (int k = 0; unknown >= 0 && k < 6; ++k) {
      g[static_cast<std::size_t>(unknown)](k) -= sign * impulse[k];
    }
  };
  for (ContactPack& pack : problem.packs()) {
    pack.evaluate_impulses(pack.v_c, pack.torsion.omega_c, true);
    const ContactPack::BodyImpulses impulses = pack.body_impulses();
    subtract(pack.a, 1, impulses.on_a);
    subtract(pack.b, -1, impulses.against_b);
  }
  for (const int i : problem.moving()) {
    SolverBody& body = problem.at(i);
    const BlockVector& along = d[static_cast<std::size_t>(body.unknown)];
    body.twist.v -= step * along.head<3>();
    body.twist.omega -= step * along.tail<3>();
  }
  return g;
}

TEST(NewtonMatrix, IsTheDerivativeOfTheGradient) {
  constexpr double kStep = 1e-7;
  const ContactSolverParameters parameters;
  RandomProblems problems(17);
  NewtonMatrix matrix;
  int compared = 0;
  constexpr int kProblems = 100;
  for (int round = 0; round < kProblems; ++round) {
    SolverBench bench;
    problems.next().state_to(bench);
    bench.complete(parameters);
    bench.set_proximal_weight(0.1, parameters);
    bench.evaluate_constraint_velocities();
    bench.update_proximal_point();
    Vectors d;
    for (std::size_t i = 0; i < bench.moving().size(); ++i) {
      d.emplace_back();
      d.back() << problems.vector(1), problems.vector(1);
    }
    // Their difference is the matrix times d.
    Vectors x = gradient(bench, d, kStep);
    const Vectors before = gradient(bench, d, -kStep);
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = (x[i] - before[i]) / (2 * kStep);
    gradient(bench, d, 0);
    matrix.analyse(bench);
    matrix.assemble(bench);
    ASSERT_TRUE(matrix.solve(x));
    double off = 0;
    for (std::size_t i = 0; i < x.size(); ++i) off = std::max(off, (x[i] - d[i]).norm());
    compared += off < 1e-4;
  }
  // A kink within the step of the difference is rare.
  EXPECT_GE(compared, kProblems * 95 / 100);
}

}  // namespace
}  // namespace aprsim::physics
