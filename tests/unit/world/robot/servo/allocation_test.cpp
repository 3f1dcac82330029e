#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/allocation_counter.hpp"
#include "tests/unit/world/robot/test_arms.hpp"
#include "world/robot/kinematics/choice/make_inverse_kinematics.hpp"
#include "world/robot/kinematics/dynamics.hpp"
#include "world/robot/servo/contact_law.hpp"
#include "world/robot/servo/servo_arm.hpp"

namespace aprsim::robot {
namespace {

using Eigen::Vector3d;

TEST(AllocationCounter, Counts) {
  const long before = aprsim::test::allocations();
  Eigen::VectorXd* vector = new Eigen::VectorXd(100);
  EXPECT_GE(aprsim::test::allocations() - before, 2);  // the object and its heap storage
  delete vector;
}

class NoAllocation : public testing::TestWithParam<bool> {
 protected:
  ArmModel model_ = GetParam() ? test::fanuc() : test::motoman();
  JointVector home_ = test::home(model_);
  JointVector zero_ = JointVector::Zero(model_.dof());
};

TEST_P(NoAllocation, KinematicsAndDynamics) {
  std::vector<Eigen::Isometry3d> X_BL(model_.links.size());
  const Payload payload{.mass_kg = 1, .com_F = {.1, 0, 0}};
  double sum = 0;
  const long before = aprsim::test::allocations();
  for (int k = 0; k < 100; ++k) {
    JointVector q = home_;
    q(0) = 0.01 * k;
    link_poses(model_, q, X_BL);
    sum += flange_pose(model_, q)(0, 3);
    const Jacobian J = point_jacobian(model_, q, model_.dof(), {0, 0, .1});
    const JointMatrix H = mass_matrix(model_, payload, q);
    sum += inverse_dynamics(model_, payload, {0, 0, -9.81}, q, zero_, zero_).sum();
    sum += J(0, 0) + H(0, 0);
    sum += normal_force({}, 1e-3, .1, .2, 1e-3);
  }
  EXPECT_EQ(aprsim::test::allocations() - before, 0);
  EXPECT_TRUE(std::isfinite(sum));
}

TEST_P(NoAllocation, InverseKinematicsThatSucceeds) {
  const auto ik = *make_inverse_kinematics(model_);
  JointVector seed = home_;
  Eigen::Isometry3d X_BF = flange_pose(model_, home_);
  const double elbow = ik->elbow_of(home_);
  int failed = 0;
  const long before = aprsim::test::allocations();
  for (int k = 0; k < 100; ++k) {
    X_BF.translation().y() += 1e-3;
    const auto q = ik->nearest(X_BF, seed, elbow);
    if (!q) {
      ++failed;
      continue;
    }
    seed = *q;
    static_cast<void>(ik->elbow_of(seed));
  }
  EXPECT_EQ(aprsim::test::allocations() - before, 0);
  EXPECT_EQ(failed, 0);
}

TEST_P(NoAllocation, ServoIdleDeviatingTrippingAndRelaxing) {
  ServoArm arm(model_, {.mass_kg = 1, .com_F = {.1, 0, 0}}, {0, 0, -9.81}, home_, 1e-3);
  JointVector push = zero_;
  push(1) = 0.6 * model_.joints[1].max_torque_nm;
  bool tripped = false;
  const long before = aprsim::test::allocations();
  for (int k = 0; k < 2000; ++k) {
    arm.step(home_, k > 100 && k < 400 ? push : zero_);
    tripped = tripped || !arm.trip_reason().empty();
  }
  arm.relax();
  arm.set_payload({});
  arm.step(arm.q(), zero_);
  EXPECT_EQ(aprsim::test::allocations() - before, 0);
  EXPECT_TRUE(tripped);
}

INSTANTIATE_TEST_SUITE_P(Arms, NoAllocation, testing::Bool(),
                         [](const auto& which) { return which.param ? "fanuc" : "motoman"; });

}  // namespace
}  // namespace aprsim::robot
