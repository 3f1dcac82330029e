#include "world/physics/constraint/large_island_solver.hpp"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/world/physics/constraint/random_heap.hpp"

namespace aprsim::physics {
namespace {

constexpr int kLayers = 4, kHeaps = 8;
constexpr int kManyBodies = 1000000;

double largest_difference_m_s(const SolverBench& a, const SolverBench& b) {
  double out = 0;
  for (int i = 0; i < a.body_count(); ++i) {
    out = std::max({out, (a.twist(i).v - b.twist(i).v).norm(),
                    0.01 * (a.twist(i).omega - b.twist(i).omega).norm()});
  }
  return out;
}

/// Both paths end at the solution of the same equations.
TEST(LargeIslandSolver, AgreesWithTheSolverOfSmallIslands) {
  RandomHeaps heaps(3);
  ContactSolverParameters small = kStrict, large = kStrict;
  small.max_small_island_bodies = kManyBodies;
  large.large_island_tolerance_m_s = 1e-8;
  int compared = 0;
  for (int i = 0; i < kHeaps; ++i) {
    const Problem heap = heaps.next(kLayers);
    SolverBench one, other;
    heap.state_to(one);
    heap.state_to(other);
    const auto by_small = one.solve(small), by_large = other.solve(large);
    if (!by_small.converged || !by_large.converged) continue;
    ++compared;
    EXPECT_LT(largest_difference_m_s(one, other), 1e-6) << "heap " << i;
  }
  EXPECT_GE(compared, kHeaps - 1);
}

/// With the tolerance of large islands the velocities differ by little more than that.
TEST(LargeIslandSolver, StaysWithinItsToleranceOfTheStrictSolution) {
  RandomHeaps heaps(4);
  ContactSolverParameters strict = kStrict;
  strict.large_island_tolerance_m_s = 1e-8;
  for (int i = 0; i < kHeaps; ++i) {
    const Problem heap = heaps.next(kLayers);
    SolverBench one, other;
    heap.state_to(one);
    heap.state_to(other);
    ASSERT_TRUE(one.solve(strict).converged) << "heap " << i;
    const auto outcome = other.solve();
    ASSERT_TRUE(outcome.converged) << "heap " << i;
    EXPECT_LE(outcome.residual_m_s, 3e-5) << "heap " << i;
    EXPECT_LT(largest_difference_m_s(one, other), 1e-3) << "heap " << i;
  }
}

/// Impulses are within their cones, and velocities follow from them, at any residual.
TEST(LargeIslandSolver, KeepsConesAndMomentumAlsoWhereItsBudgetEnds) {
  RandomHeaps heaps(5);
  ContactSolverParameters parameters;
  for (const int budget : {0, 1, 5, 200}) {
    parameters.max_newton_steps = budget;
    const Problem heap = heaps.next(kLayers);
    SolverBench bench;
    heap.state_to(bench);
    const auto outcome = bench.solve(parameters);
    EXPECT_EQ(outcome.converged, budget == 200) << "budget " << budget;
    std::vector<Eigen::Vector3d> momenta;
    for (const auto& body : heap.bodies) momenta.emplace_back(body.mass_kg * body.free.v);
    for (std::size_t k = 0; k < heap.contacts.size(); ++k) {
      const ContactDescription& contact = heap.contacts[k];
      const Eigen::Vector3d impulse = bench.contact_impulse_ns(static_cast<int>(k));
      const double normal = impulse.dot(contact.n);
      EXPECT_GE(normal, -1e-12);
      EXPECT_LE((impulse - normal * contact.n).norm(), contact.friction * normal + 1e-12);
      momenta[static_cast<std::size_t>(contact.a)] += impulse;
      if (contact.b >= 0) momenta[static_cast<std::size_t>(contact.b)] -= impulse;
    }
    for (std::size_t i = 0; i < heap.bodies.size(); ++i) {
      const Eigen::Vector3d found = heap.bodies[i].mass_kg * bench.twist(static_cast<int>(i)).v;
      EXPECT_LT((found - momenta[i]).norm(), 1e-12) << "budget " << budget << " body " << i;
    }
  }
}

/// The bits depend on the problem alone, not on what was solved before.
TEST(LargeIslandSolver, GivesTheSameBitsAgain) {
  RandomHeaps heaps(6);
  const Problem first = heaps.next(kLayers), second = heaps.next(kLayers + 1);
  SolverBench used, fresh;
  first.state_to(used);
  ASSERT_TRUE(used.solve().converged);
  second.state_to(used);
  second.state_to(fresh);
  const auto again = used.solve(), once = fresh.solve();
  EXPECT_EQ(again.newton_steps, once.newton_steps);
  EXPECT_EQ(largest_difference_m_s(used, fresh), 0);
}

/// A solved heap in which one body is struck is solved again where it was struck.
TEST(RegionSolver, SolvesWhatWasStruckOnly) {
  RandomHeaps heaps(7);
  Problem heap = heaps.next(2 * kLayers);
  SolverBench bench;
  heap.state_to(bench);
  ContactSolverParameters strict = kStrict;
  strict.large_island_tolerance_m_s = 1e-8;
  ASSERT_TRUE(bench.solve(strict).converged);
  std::vector<Twist> before;
  for (int i = 0; i < bench.body_count(); ++i) before.push_back(bench.twist(i));
  const int struck = bench.body_count() - 1;
  bench.at(struck).free_twist.v.x() += 1e-4;
  const ContactResidual first = bench.residual(strict);
  ASSERT_GT(first.max_m_s(), 1e-6);
  RegionSolver regions;
  constexpr double kSolved = 1e-6;
  const RegionSolver::Result result =
      regions.solve(bench, strict, ToleranceSchedule(strict, false), kSolved, first);
  EXPECT_GT(result.regions, 0);
  EXPECT_LE(result.residual.max_m_s(), kSolved);
  EXPECT_LT(result.newton_steps, 10);
  // The bodies of the lowest layer do not notice.
  for (int i = 0; i < RandomHeaps::kLayer; ++i) {
    EXPECT_LT((bench.twist(i).v - before[static_cast<std::size_t>(i)].v).norm(), kSolved) << i;
  }
}

}  // namespace
}  // namespace aprsim::physics
