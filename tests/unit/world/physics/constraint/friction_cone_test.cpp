#include "world/physics/constraint/friction_cone.hpp"

#include <random>

#include <gtest/gtest.h>

namespace aprsim::physics {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

class FrictionConeTest : public testing::Test {
 protected:
  double real(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  Vector3d vector() { return {real(-1, 1), real(-1, 1), real(-1, 1)}; }
  Vector3d within(double mu) {
    const double n = real(0, 1), angle = real(-3, 3), t = mu * n * real(0, 1);
    return {n, t * std::cos(angle), t * std::sin(angle)};
  }
  static Matrix3d derivative(const ImpulseDerivative& G, int lane) {
    Matrix3d out;
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) out(i, k) = G.at[i][k][lane];
    }
    return out;
  }
  std::mt19937 engine_{3};
};

// (z - P z)' D (c - P z) <= 0 for all c of a convex set is the projection in the metric D.
TEST_F(FrictionConeTest, ProjectsToTheNearestInItsMetric) {
  for (int round = 0; round < 300; ++round) {
    const double mu = real(0, 1);
    const Vector3d metric(real(0.1, 3), real(0.1, 3), 0);
    const Eigen::DiagonalMatrix<double, 3> D(metric[0], metric[1], metric[1]);
    FrictionCone cone;
    cone.set(broadcast(mu), broadcast(metric[0]), broadcast(metric[1]));
    Vector3x4 z;
    for (int lane = 0; lane < kLanes; ++lane) z.set(lane, vector());
    const Vector3x4 projected = cone.project(z);
    for (int lane = 0; lane < kLanes; ++lane) {
      const Vector3d p = projected.at(lane);
      ASSERT_LE(p.tail<2>().norm(), mu * p.x() + 1e-12);
      for (int k = 0; k < 20; ++k) {
        ASSERT_LE((z.at(lane) - p).dot(D * (within(mu) - p)), 1e-12) << "round " << round;
      }
    }
  }
}

TEST_F(FrictionConeTest, DerivativeIsThatOfTheProjection) {
  constexpr double kStep = 1e-6;
  for (int round = 0; round < 100; ++round) {
    const double n = real(0.1, 3), t = real(0.1, 3);
    const Vector3d inverse(1 / n, 1 / t, 1 / t);
    FrictionCone cone;
    cone.set(broadcast(0.5), broadcast(n), broadcast(t));
    const Vector3d z = vector();
    ImpulseDerivative G;
    const Vector3d p = cone.project(Vector3x4::broadcast(z), &G).at(0);
    Vector3x4 moved;  // by the velocities of three axes
    for (int k = 0; k < 3; ++k) {
      moved.set(k, z - kStep * inverse.cwiseProduct(Vector3d::Unit(k)));
    }
    moved.set(3, z);
    const Vector3x4 there = cone.project(moved);
    for (int k = 0; k < 3; ++k) {
      const Vector3d expected = (p - there.at(k)) / kStep;
      EXPECT_LT((derivative(G, 1).col(k) - expected).norm(), 1e-4 * (1 + expected.norm()));
    }
  }
}

TEST_F(FrictionConeTest, LanesWithoutMetricBearNothing) {
  FrictionCone cone;
  cone.set(Vec4d{0.5, 0, 0, 0}, Vec4d{2, 0, 0, 0}, Vec4d{2, 0, 0, 0});
  ImpulseDerivative G;
  const Vector3x4 projected = cone.project(Vector3x4::broadcast({-1, 0, 0}), &G);
  for (int lane = 0; lane < kLanes; ++lane) {
    EXPECT_EQ(projected.at(lane), Vector3d::Zero());
    EXPECT_EQ(derivative(G, lane), Matrix3d::Zero());
  }
}

}  // namespace
}  // namespace aprsim::physics
