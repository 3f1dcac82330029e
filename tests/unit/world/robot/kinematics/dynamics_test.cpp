#include "world/robot/kinematics/dynamics.hpp"

#include <cmath>

#include <gtest/gtest.h>
#include <kdl/chaindynparam.hpp>
#include <kdl/chainidsolver_recursive_newton_euler.hpp>

#include "tests/unit/world/robot/test_arms.hpp"

namespace aprsim::robot {
namespace {

using Eigen::Vector3d;

const Vector3d kGravity(0, 0, -9.81);

KDL::Vector to_kdl(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }

KDL::RotationalInertia inertia_to_kdl(const Eigen::Matrix3d& I) {
  return KDL::RotationalInertia(I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2));
}

KDL::JntArray joints_to_kdl(const JointVector& v) {
  KDL::JntArray out(static_cast<unsigned>(v.size()));
  for (unsigned i = 0; i < out.rows(); ++i) out(i) = v(i);
  return out;
}

/// The same chain in KDL, built from the model's figures; both arms have unrotated joint frames.
KDL::Chain chain(const ArmModel& model, const Payload& payload) {
  KDL::Chain out;
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    const Joint& joint = model.joints[i];
    const Link& link = model.links[i + 1];
    const KDL::Vector origin = to_kdl(joint.X_PJ.translation());
    KDL::RigidBodyInertia inertia(link.mass_kg, to_kdl(link.com_L), inertia_to_kdl(link.inertia_L));
    if (i + 1 == model.joints.size()) {
      inertia = inertia + KDL::RigidBodyInertia(payload.mass_kg, to_kdl(payload.com_F),
                                                inertia_to_kdl(payload.inertia_F));
    }
    const KDL::Joint kdl_joint(joint.name, origin, to_kdl(joint.axis), KDL::Joint::RotAxis, 1, 0,
                               joint.rotor_inertia_kg_m2);
    out.addSegment(KDL::Segment(link.name, kdl_joint, KDL::Frame(origin), inertia));
  }
  return out;
}

Payload gripper_and_part() {
  Payload payload{.mass_kg = 2.5, .com_F = {.09, -.01, .04}};
  payload.inertia_F << .004, .0003, -.0002, .0003, .006, .0001, -.0002, .0001, .005;
  return payload;
}

JointVector random_vector(int n, double range, std::mt19937_64& random) {
  JointVector v(n);
  for (int i = 0; i < n; ++i) v(i) = std::uniform_real_distribution<double>(-range, range)(random);
  return v;
}

class Dynamics : public testing::TestWithParam<std::tuple<bool, bool>> {
 protected:
  ArmModel model_ = std::get<0>(GetParam()) ? test::fanuc() : test::motoman();
  Payload payload_ = std::get<1>(GetParam()) ? gripper_and_part() : Payload{};
  int n_ = model_.dof();
  std::mt19937_64 random_{5};
};

TEST_P(Dynamics, AgreesWithKdl) {
  const KDL::Chain kdl = chain(model_, payload_);
  KDL::ChainIdSolver_RNE inverse(kdl, to_kdl(kGravity));
  KDL::ChainDynParam parameters(kdl, to_kdl(kGravity));
  const auto rows = static_cast<unsigned>(n_);
  KDL::JntArray torques(rows);
  KDL::JntSpaceInertiaMatrix inertia(static_cast<int>(n_));
  const KDL::Wrenches none(kdl.getNrOfSegments(), KDL::Wrench::Zero());
  double worst_torque = 0, worst_inertia = 0;
  for (int k = 0; k < 2000; ++k) {
    const JointVector q = test::random_q(model_, random_);
    const JointVector qd = random_vector(n_, 4, random_), qdd = random_vector(n_, 30, random_);
    ASSERT_EQ(
        inverse.CartToJnt(joints_to_kdl(q), joints_to_kdl(qd), joints_to_kdl(qdd), none, torques),
        0);
    ASSERT_EQ(parameters.JntToMass(joints_to_kdl(q), inertia), 0);
    const JointVector tau = inverse_dynamics(model_, payload_, kGravity, q, qd, qdd);
    const JointMatrix H = mass_matrix(model_, payload_, q);
    for (int i = 0; i < n_; ++i) {
      const auto row = static_cast<unsigned>(i);
      worst_torque = std::max(worst_torque, std::abs(tau(i) - torques(row)));
      for (int j = 0; j < n_; ++j) {
        worst_inertia =
            std::max(worst_inertia, std::abs(H(i, j) - inertia(row, static_cast<unsigned>(j))));
      }
    }
  }
  EXPECT_LT(worst_torque, 1e-9);
  EXPECT_LT(worst_inertia, 1e-12);
}

TEST_P(Dynamics, MassMatrixIsThatOfInverseDynamics) {
  const JointVector zero = JointVector::Zero(n_);
  for (int k = 0; k < 200; ++k) {
    const JointVector q = test::random_q(model_, random_);
    const JointMatrix H = mass_matrix(model_, payload_, q);
    EXPECT_EQ(H, H.transpose());
    for (int i = 0; i < n_; ++i) {
      const JointVector column =
          inverse_dynamics(model_, payload_, Vector3d::Zero(), q, zero, JointVector::Unit(n_, i));
      ASSERT_LT((column - H.col(i)).cwiseAbs().maxCoeff(), 1e-12);
    }
  }
}

TEST_P(Dynamics, PowerIsTheChangeOfKineticEnergy) {
  constexpr double kStep = 1e-5;
  for (int k = 0; k < 200; ++k) {
    const JointVector q = test::random_q(model_, random_);
    const JointVector qd = random_vector(n_, 2, random_), qdd = random_vector(n_, 10, random_);
    const JointVector tau = inverse_dynamics(model_, payload_, Vector3d::Zero(), q, qd, qdd);
    const auto energy = [&](double t) {
      const JointVector v = qd + t * qdd;
      const JointVector at = q + t * qd + t * t / 2 * qdd;
      return 0.5 * v.dot(mass_matrix(model_, payload_, at) * v);
    };
    const double power = (energy(kStep) - energy(-kStep)) / (2 * kStep);
    ASSERT_NEAR(qd.dot(tau), power, 1e-5 * (1 + std::abs(power)));
  }
}

TEST_P(Dynamics, GravityTorqueIsTheWeightOnTheJacobian) {
  const JointVector zero = JointVector::Zero(n_);
  const JointVector q = test::random_q(model_, random_);
  JointVector expected = zero;
  for (int link = 1; link <= n_; ++link) {
    const Link& body = model_.links[static_cast<std::size_t>(link)];
    expected -= point_jacobian(model_, q, link, body.com_L).topRows<3>().transpose() *
                (body.mass_kg * kGravity);
  }
  expected -= point_jacobian(model_, q, n_, payload_.com_F).topRows<3>().transpose() *
              (payload_.mass_kg * kGravity);
  const JointVector tau = inverse_dynamics(model_, payload_, kGravity, q, zero, zero);
  EXPECT_LT((tau - expected).cwiseAbs().maxCoeff(), 1e-11);
}

INSTANTIATE_TEST_SUITE_P(Arms, Dynamics, testing::Combine(testing::Bool(), testing::Bool()),
                         [](const auto& which) {
                           return std::string(std::get<0>(which.param) ? "fanuc" : "motoman") +
                                  (std::get<1>(which.param) ? "_loaded" : "_bare");
                         });

TEST(RotorInertia, AddsToTheDiagonalOnly) {
  ArmModel model = test::fanuc();
  const JointVector q = test::home(model);
  const JointMatrix with = mass_matrix(model, {}, q);
  for (Joint& joint : model.joints) joint.rotor_inertia_kg_m2 = 0;
  const JointMatrix difference = with - mass_matrix(model, {}, q);
  EXPECT_NEAR(difference(1, 1), .256, 1e-12);
  EXPECT_NEAR(difference(5, 5), .0045, 1e-12);
  EXPECT_EQ(difference(0, 1), 0);
}

}  // namespace
}  // namespace aprsim::robot
