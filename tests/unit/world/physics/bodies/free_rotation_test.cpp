// Rotation without torque: energy, angular momentum, order of convergence, symmetric cases.

#include "world/physics/bodies/free_rotation.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace aprsim::physics {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

struct Spin {
  Matrix3d inertia_B;
  Quaterniond q_WB;
  Vector3d omega_W;

  [[nodiscard]] Matrix3d inertia_W() const {
    const Matrix3d R = q_WB.matrix();
    return R * inertia_B * R.transpose();
  }
  [[nodiscard]] Vector3d momentum_W() const { return inertia_W() * omega_W; }
  [[nodiscard]] double energy_j() const { return 0.5 * omega_W.dot(momentum_W()); }

  void advance(double step_s) {
    const Vector3d momentum = momentum_W();
    const Vector3d turn = step_s * mean_free_omega(inertia_B, q_WB, omega_W, step_s);
    const double angle = turn.norm();
    q_WB = (Quaterniond(Eigen::AngleAxisd(angle, turn / angle)) * q_WB).normalized();
    omega_W = inertia_W().inverse() * momentum;
  }
};

/// Any body's inertia: that of a box of random edges, in random axes.
Spin random_spin(std::mt19937& random, double max_rate) {
  std::uniform_real_distribution<> edge(0.01, 0.2), any(-1, 1);
  const Vector3d size(edge(random), edge(random), edge(random));
  const Vector3d squares = size.cwiseProduct(size);
  const Quaterniond axes =
      Quaterniond(any(random), any(random), any(random), any(random)).normalized();
  const Matrix3d R = axes.matrix();
  const Vector3d principal = (Vector3d::Constant(squares.sum()) - squares) / 12;
  const Vector3d omega = Vector3d(any(random), any(random), any(random)).normalized() * max_rate;
  return {R * principal.asDiagonal() * R.transpose(),
          Quaterniond(any(random), any(random), any(random), any(random)).normalized(), omega};
}

TEST(FreeRotation, KeepsEnergyAndAngularMomentumToRounding) {
  std::mt19937 random(7);
  for (int round = 0; round < 20; ++round) {
    Spin spin = random_spin(random, 60);
    const Vector3d momentum = spin.momentum_W();
    const double energy = spin.energy_j();
    for (int step = 0; step < 20'000; ++step) spin.advance(1e-3);
    EXPECT_NEAR(spin.energy_j() / energy, 1, 1e-11) << "round " << round;
    EXPECT_LT((spin.momentum_W() - momentum).norm(), 1e-12 * momentum.norm()) << "round " << round;
  }
}

TEST(FreeRotation, ConvergesWithTheFourthOrder) {
  std::mt19937 random(3);
  for (int round = 0; round < 20; ++round) {
    const Spin begin = random_spin(random, 20);
    const auto attitude_after = [&](int steps) {
      Spin spin = begin;
      for (int i = 0; i < steps; ++i) spin.advance(0.064 / steps);
      return spin.q_WB;
    };
    const Quaterniond exact = attitude_after(1024);
    const double coarse = exact.angularDistance(attitude_after(32));
    const double fine = exact.angularDistance(attitude_after(64));
    EXPECT_LT(fine, std::max(coarse / 12, 1e-10)) << "round " << round;
  }
}

TEST(FreeRotation, AboutAPrincipalAxisIsConstant) {
  const Matrix3d inertia = Vector3d(1, 2, 3).asDiagonal();
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d omega = 5 * Vector3d::Unit(axis);
    EXPECT_EQ(mean_free_omega(inertia, Quaterniond::Identity(), omega, 1e-3), omega);
  }
}

/// Closed form (Goldstein): the axis of a symmetric body precesses about the angular momentum L at
/// |L| / I1.
TEST(FreeRotation, PrecessesAsASymmetricBodyDoes) {
  const double i1 = 1e-4, i3 = 1.7e-4;
  Spin spin{Vector3d(i1, i1, i3).asDiagonal(), Quaterniond::Identity(), Vector3d(4, 0, 12)};
  const Vector3d momentum = spin.momentum_W();
  const double time_s = 2, rate = momentum.norm() / i1;
  for (int i = 0; i < 2000; ++i) spin.advance(1e-3);
  const Vector3d expected =
      Eigen::AngleAxisd(rate * time_s, momentum.normalized()) * Vector3d::UnitZ();
  EXPECT_LT((spin.q_WB * Vector3d::UnitZ() - expected).norm(), 1e-6);
}

TEST(FreeRotation, IsTheSameInEveryFrame) {
  std::mt19937 random(11);
  std::uniform_real_distribution<> any(-1, 1);
  for (int round = 0; round < 50; ++round) {
    const Spin spin = random_spin(random, 30);
    const Quaterniond turn =
        Quaterniond(any(random), any(random), any(random), any(random)).normalized();
    const Vector3d here = mean_free_omega(spin.inertia_B, spin.q_WB, spin.omega_W, 1e-3);
    const Vector3d there =
        mean_free_omega(spin.inertia_B, turn * spin.q_WB, turn * spin.omega_W, 1e-3);
    EXPECT_LT((turn * here - there).norm(), 1e-12 * here.norm());
  }
}

}  // namespace
}  // namespace aprsim::physics
