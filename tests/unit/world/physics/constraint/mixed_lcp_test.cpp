#include "world/physics/constraint/mixed_lcp.hpp"

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

#include "world/physics/constraint/friction_homotopy.hpp"

namespace aprsim::physics {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A random symmetric positive definite matrix.
Eigen::MatrixXd random_matrix(int n, std::mt19937& random) {
  std::normal_distribution<double> normal;
  Eigen::MatrixXd j(n, n + 2);
  for (double& value : j.reshaped()) value = normal(random);
  return j * j.transpose() + 1e-3 * Eigen::MatrixXd::Identity(n, n);
}

void fill(MixedLcp& system, const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  for (int i = 0; i < system.rows(); ++i) {
    for (int k = 0; k < system.rows(); ++k) system.column(i)[k] = a(k, i);
    system.b(i) = b[i];
  }
}

Eigen::VectorXd solution(const MixedLcp& system) {
  Eigen::VectorXd x(system.rows());
  for (int i = 0; i < system.rows(); ++i) x[i] = system.x(i);
  return x;
}

bool solve_coupled(MixedLcp& system, int most_rounds, int most_changes) {
  FrictionHomotopy homotopy;
  system.solve_estimated(most_rounds);
  return homotopy.continue_friction(system, most_changes);
}

/// How far a row is from being solved: between its bounds w = 0, at them w points outward.
double fault(double x, double w, double lo, double hi) {
  if (x < lo - 1e-9 || x > hi + 1e-9) return kInfinity;
  if (x > lo + 1e-9 && x < hi - 1e-9) return std::abs(w);
  return x <= lo + 1e-9 ? std::max(0.0, -w) : std::max(0.0, w);
}

TEST(MixedLcp, RowsAreBetweenTheirBoundsOrPushedAgainstThem) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int round = 0; round < 300; ++round) {
    const int n = 1 + round % 40;
    const Eigen::MatrixXd a = random_matrix(n, random);
    MixedLcp system;
    Eigen::VectorXd b(n), lo(n), hi(n);
    for (int i = 0; i < n; ++i) {
      b[i] = 20 * uniform(random) - 10;
      lo[i] = -uniform(random);
      hi[i] = uniform(random) < 0.3 ? kInfinity : uniform(random);
      system.add({.lo = lo[i], .hi = hi[i]});
    }
    fill(system, a, b);
    system.solve_decoupled();
    const Eigen::VectorXd x = solution(system), w = a * x - b;
    for (int i = 0; i < n; ++i) EXPECT_LT(fault(x[i], w[i], lo[i], hi[i]), 1e-7) << n;
  }
}

// There is not always a solution to be found on the way; where one is, it is exact.
TEST(MixedLcp, TakesAsManyRowsAsItHasRoomForAndNoMore) {
  MixedLcp system;
  for (int i = 0; i < MixedLcp::kCapacity; ++i) {
    ASSERT_EQ(system.add({.lo = -1, .hi = 1}), i);
    system.column(i)[i] = 1;
    system.b(i) = 0.5;
  }
  EXPECT_THROW(system.add({.lo = -1, .hi = 1}), std::length_error);
  EXPECT_EQ(system.rows(), MixedLcp::kCapacity);
  EXPECT_TRUE(system.solve_estimated(10));
  for (int i = 0; i < MixedLcp::kCapacity; ++i) EXPECT_NEAR(system.x(i), 0.5, 1e-12);
}

TEST(MixedLcp, FrictionIsBoundedByTheNormalsFoundWithIt) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> uniform(-1, 1);
  int found = 0;
  constexpr int kRounds = 200;
  for (int round = 0; round < kRounds; ++round) {
    const double mu = round % 2 == 0 ? 0.3 : 1.0;
    const int contacts = 1 + round % 8, n = 3 * contacts;
    const Eigen::MatrixXd a = random_matrix(n, random);
    MixedLcp system;
    Eigen::VectorXd b(n);
    for (int c = 0; c < contacts; ++c) {
      const int normal = system.add({.lo = 0, .hi = kInfinity});
      system.add({.normal = normal, .mu = mu});
      system.add({.normal = normal, .mu = mu});
    }
    for (double& value : b) value = 5 * uniform(random);
    fill(system, a, b);
    const bool exact = solve_coupled(system, round % 3 == 0 ? 0 : 60, 100);
    found += exact;
    const Eigen::VectorXd x = solution(system), w = a * x - b;
    for (int c = 0; c < contacts; ++c) {
      EXPECT_LT(fault(x[Eigen::Index{3} * c], w[Eigen::Index{3} * c], 0, kInfinity), 1e-6);
      const double bound = mu * x[Eigen::Index{3} * c];
      for (int i = 3 * c + 1; i < 3 * c + 3 && exact; ++i) {
        const double off = bound < 1e-9 ? std::abs(x[i]) : fault(x[i], w[i], -bound, bound);
        EXPECT_LT(off, 1e-6) << "round " << round;
      }
    }
  }
  EXPECT_GT(found, kRounds * 9 / 10);
}

// Columns of the identity: every row on its own.
TEST(MixedLcp, ABlockOnATableSticksOrSlides) {
  for (const double pull : {0.2, 0.5}) {
    MixedLcp system;
    const int normal = system.add({.lo = 0, .hi = kInfinity});
    system.add({.normal = normal, .mu = 0.3});
    fill(system, Eigen::MatrixXd::Identity(2, 2), Eigen::Vector2d(1, pull));
    ASSERT_TRUE(solve_coupled(system, 100, 10));
    EXPECT_NEAR(system.x(0), 1, 1e-12);
    EXPECT_NEAR(system.x(1), std::min(pull, 0.3), 1e-9);
  }
}

}  // namespace
}  // namespace aprsim::physics
