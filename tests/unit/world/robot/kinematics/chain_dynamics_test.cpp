// Dynamics of chains with turned frames, prismatic joints and a flange beside the last axis,
// against Lagrange's equations with numeric derivatives.

#include <cmath>
#include <functional>
#include <ostream>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "tests/unit/world/robot/chains.hpp"
#include "tests/unit/world/robot/test_arms.hpp"
#include "world/robot/kinematics/dynamics.hpp"

namespace aprsim::robot {
namespace {

const Eigen::Vector3d kDown(0, 0, -9.81);

struct SwingingArm {
  const char* name;
  std::function<ArmModel()> make;
};

void PrintTo(const SwingingArm& arm, std::ostream* out) { *out << arm.name; }

class ChainDynamics : public testing::TestWithParam<SwingingArm> {
 protected:
  ArmModel model_ = GetParam().make();
  int n_ = model_.dof();
  Payload payload_{.mass_kg = 1.5, .com_F = {.03, -.02, .1}};
  std::mt19937_64 random_{29};

  void SetUp() override {
    payload_.inertia_F << .004, .0003, -.0002, .0003, .006, .0001, -.0002, .0001, .005;
  }

  JointVector random_rates(double range) {
    JointVector v(n_);
    for (int i = 0; i < n_; ++i) {
      v(i) = std::uniform_real_distribution<double>(-range, range)(random_);
    }
    return v;
  }

  double potential(const JointVector& q) const {
    std::vector<Eigen::Isometry3d> X_BL(model_.links.size());
    link_poses(model_, q, X_BL);
    double sum = -payload_.mass_kg * kDown.dot(X_BL.back() * payload_.com_F);
    for (std::size_t i = 1; i < X_BL.size(); ++i) {
      sum -= model_.links[i].mass_kg * kDown.dot(X_BL[i] * model_.links[i].com_L);
    }
    return sum;
  }

  /// From the bodies' Jacobians.
  JointMatrix inertia(const JointVector& q) const {
    std::vector<Eigen::Isometry3d> X_BL(model_.links.size());
    link_poses(model_, q, X_BL);
    JointMatrix H = JointMatrix::Zero(n_, n_);
    const auto add = [&](int link, double mass, const Eigen::Vector3d& com,
                         const Eigen::Matrix3d& inertia_L) {
      const Jacobian J = point_jacobian(model_, q, link, com);
      const Eigen::Matrix3d R = X_BL[static_cast<std::size_t>(link)].linear();
      H += mass * J.topRows<3>().transpose() * J.topRows<3>() +
           J.bottomRows<3>().transpose() * (R * inertia_L * R.transpose()) * J.bottomRows<3>();
    };
    for (int i = 1; i <= n_; ++i) {
      const Link& link = model_.links[static_cast<std::size_t>(i)];
      add(i, link.mass_kg, link.com_L, link.inertia_L);
      H(i - 1, i - 1) += model_.joints[static_cast<std::size_t>(i - 1)].rotor_inertia_kg_m2;
    }
    add(n_, payload_.mass_kg, payload_.com_F, payload_.inertia_F);
    return H;
  }
};

TEST_P(ChainDynamics, JacobianIsTheDerivativeOfThePose) {
  constexpr double kStep = 1e-6;
  const Eigen::Vector3d p(.1, -.2, .3);
  for (int k = 0; k < 50; ++k) {
    const JointVector q = test::random_q(model_, random_);
    const Jacobian J = point_jacobian(model_, q, n_, p);
    for (int i = 0; i < n_; ++i) {
      const JointVector step = kStep * JointVector::Unit(n_, i);
      const Eigen::Isometry3d before = flange_pose(model_, q - step),
                              after = flange_pose(model_, q + step);
      const Eigen::Vector3d velocity = (after * p - before * p) / (2 * kStep);
      const Eigen::Matrix3d spin = (after.linear() - before.linear()) / (2 * kStep) *
                                   flange_pose(model_, q).linear().transpose();
      ASSERT_LT((J.col(i).head<3>() - velocity).norm(), 1e-8);
      const Eigen::Vector3d omega(spin(2, 1), spin(0, 2), spin(1, 0));
      ASSERT_LT((J.col(i).tail<3>() - omega).norm(), 1e-8);
    }
  }
}

TEST_P(ChainDynamics, MassMatrixIsThatOfTheBodies) {
  for (int k = 0; k < 100; ++k) {
    const JointVector q = test::random_q(model_, random_);
    const JointMatrix H = mass_matrix(model_, payload_, q);
    ASSERT_LT((H - inertia(q)).cwiseAbs().maxCoeff(), 1e-11);
  }
}

TEST_P(ChainDynamics, InverseDynamicsIsLagranges) {
  constexpr double kStep = 1e-5;
  for (int k = 0; k < 30; ++k) {
    const JointVector q = test::random_q(model_, random_);
    const JointVector qd = random_rates(2), qdd = random_rates(5);
    // tau = H qdd + sum_k dH/dq_k qd_k qd - dT/dq + dV/dq
    JointVector expected = inertia(q) * qdd;
    for (int i = 0; i < n_; ++i) {
      const JointVector step = kStep * JointVector::Unit(n_, i);
      const JointMatrix dH = (inertia(q + step) - inertia(q - step)) / (2 * kStep);
      expected += qd(i) * (dH * qd);
      expected(i) -= 0.5 * qd.dot(dH * qd);
      expected(i) += (potential(q + step) - potential(q - step)) / (2 * kStep);
    }
    const JointVector tau = inverse_dynamics(model_, payload_, kDown, q, qd, qdd);
    ASSERT_LT((tau - expected).cwiseAbs().maxCoeff(), 1e-6 * (1 + expected.cwiseAbs().maxCoeff()));
  }
}

TEST_P(ChainDynamics, AFreelySwingingArmKeepsItsEnergy) {
  constexpr double kStep = 2e-4;
  const JointVector zero = JointVector::Zero(n_);
  JointVector q = test::random_q(model_, random_, 0.5), qd = random_rates(0.5);
  const auto acceleration = [&](const JointVector& at, const JointVector& rate) {
    const JointVector bias = inverse_dynamics(model_, payload_, kDown, at, rate, zero);
    const JointMatrix H = mass_matrix(model_, payload_, at);
    return JointVector(H.ldlt().solve(-bias));
  };
  const auto energy = [&] {
    return 0.5 * qd.dot(mass_matrix(model_, payload_, q) * qd) + potential(q);
  };
  const double start = energy();
  double fastest = 0;
  for (int k = 0; k < 2000; ++k) {
    // Runge and Kutta's fourth order.
    const JointVector a1 = acceleration(q, qd);
    const JointVector v2 = qd + kStep / 2 * a1, a2 = acceleration(q + kStep / 2 * qd, v2);
    const JointVector v3 = qd + kStep / 2 * a2, a3 = acceleration(q + kStep / 2 * v2, v3);
    const JointVector v4 = qd + kStep * a3, a4 = acceleration(q + kStep * v3, v4);
    q += kStep / 6 * (qd + 2 * v2 + 2 * v3 + v4);
    qd += kStep / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
    fastest = std::max(fastest, qd.cwiseAbs().maxCoeff());
  }
  EXPECT_GT(fastest, 0.5);
  EXPECT_NEAR(energy(), start, 1e-4);
}

INSTANTIATE_TEST_SUITE_P(Arms, ChainDynamics,
                         testing::Values(SwingingArm{"ur5e", [] { return test::load("ur5e"); }},
                                         SwingingArm{"irb120", [] { return test::load("irb120"); }},
                                         SwingingArm{"panda", [] { return test::load("panda"); }},
                                         SwingingArm{"scara600",
                                                     [] { return test::load("scara600"); }},
                                         SwingingArm{"rail_seven", test::rail_seven},
                                         SwingingArm{"gantry_six", test::gantry_six},
                                         SwingingArm{"skew_seven", test::skew_seven}),
                         [](const auto& which) { return std::string(which.param.name); });

}  // namespace
}  // namespace aprsim::robot
