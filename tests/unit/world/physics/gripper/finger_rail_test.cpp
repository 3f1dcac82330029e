#include "world/physics/gripper/finger_rail.hpp"

#include <gtest/gtest.h>

namespace aprsim::physics {
namespace {

using Eigen::Vector3d;

/// A finger beside its palm, both turned anyhow, that closes along its -y.
class Hand : public ::testing::Test {
 protected:
  Hand() {
    const Eigen::Quaterniond q(Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()));
    for (RigidBody* body : {&palm_, &finger_}) body->set_orientation(q);
    palm_.set_position({0.3, -0.2, 1});
    finger_.set_position(palm_.p_W() + palm_.R_WB() * Vector3d(0, 0.03, 0.05));
    closing_W_ = -finger_.R_WB().col(1);
    rail_ = FingerRail(finger_, palm_, closing_W_);
  }
  RigidBody palm_, finger_;
  Vector3d closing_W_;
  FingerRail rail_;
};

TEST_F(Hand, IsOpenWhereItWasBuilt) {
  EXPECT_NEAR(rail_.motion(finger_, palm_).travel_m, 0, 1e-15);
  EXPECT_EQ(rail_.motion(finger_, palm_).rate_m_s, 0);
}

TEST_F(Hand, MeasuresTravelAndRateAlongTheRailWhereverTheHandIs) {
  const Eigen::Isometry3d D(Eigen::AngleAxisd(1.1, Vector3d::UnitX()));
  finger_.set_position(finger_.p_W() + 4e-3 * closing_W_);
  for (RigidBody* body : {&palm_, &finger_}) {
    body->set_position(D * body->p_W());
    body->set_orientation(Eigen::Matrix3d(D.linear() * body->R_WB()));
    body->set_velocity({1, 2, 3}, Vector3d::Zero());
  }
  const Vector3d closing_W = D.linear() * closing_W_;
  finger_.set_velocity(finger_.v_W() + 0.05 * closing_W, Vector3d::Zero());
  EXPECT_NEAR(rail_.motion(finger_, palm_).travel_m, 4e-3, 1e-14);
  EXPECT_NEAR(rail_.motion(finger_, palm_).rate_m_s, 0.05, 1e-14);
}

TEST_F(Hand, PushesWithoutNetForceOrTorque) {
  rail_.apply_force(finger_, palm_, 60);
  EXPECT_LT((finger_.force_W() - 60 * closing_W_).norm(), 1e-12);
  EXPECT_LT((finger_.force_W() + palm_.force_W()).norm(), 1e-14);
  const Vector3d about_palm = finger_.torque_W() + palm_.torque_W() +
                              (finger_.p_W() - palm_.p_W()).cross(finger_.force_W());
  EXPECT_LT(about_palm.norm(), 1e-12);
}

}  // namespace
}  // namespace aprsim::physics
