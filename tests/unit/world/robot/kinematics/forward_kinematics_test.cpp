#include <array>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/unit/world/robot/test_arms.hpp"
#include "world/robot/kinematics/dynamics.hpp"

namespace aprsim::robot {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Translation3d;
using Eigen::Vector3d;

const Vector3d kX = Vector3d::UnitX(), kY = Vector3d::UnitY(), kZ = Vector3d::UnitZ();

/// The chain written out from the robot's drawing, not from the file.
Isometry3d fanuc_drawing(const JointVector& q) {
  return Isometry3d(Translation3d(0, 0, .33) * AngleAxisd(q(0), kZ) * Translation3d(.05, 0, 0) *
                    AngleAxisd(q(1), kY) * Translation3d(0, 0, .33) * AngleAxisd(-q(2), kY) *
                    Translation3d(.335, 0, .035) * AngleAxisd(-q(3), kX) * AngleAxisd(-q(4), kY) *
                    AngleAxisd(-q(5), kX) * Translation3d(.08, 0, 0));
}

Isometry3d motoman_drawing(const JointVector& q) {
  return Isometry3d(Translation3d(0, 0, .41) * AngleAxisd(q(0), kZ) * AngleAxisd(q(1), kY) *
                    AngleAxisd(q(2), kZ) * Translation3d(0, 0, .49) * AngleAxisd(-q(3), kY) *
                    AngleAxisd(-q(4), kZ) * Translation3d(0, 0, .42) * AngleAxisd(-q(5), kY) *
                    AngleAxisd(-q(6), kZ) * Translation3d(0, 0, .18));
}

class Kinematics : public testing::TestWithParam<bool> {
 protected:
  ArmModel model_ = GetParam() ? test::fanuc() : test::motoman();
  std::mt19937_64 random_{7};
};

TEST_P(Kinematics, FlangeMatchesTheDrawing) {
  for (int n = 0; n < 2000; ++n) {
    const JointVector q = test::random_q(model_, random_);
    const Isometry3d expected = GetParam() ? fanuc_drawing(q) : motoman_drawing(q);
    const Isometry3d X_BF = flange_pose(model_, q);
    ASSERT_LT((X_BF.translation() - expected.translation()).norm(), 1e-14);
    ASSERT_LT(test::angle_between(X_BF.linear(), expected.linear()), 1e-14);
  }
}

TEST_P(Kinematics, LinkPosesEndAtTheFlange) {
  const JointVector q = test::random_q(model_, random_);
  std::vector<Isometry3d> X_BL(model_.links.size());
  link_poses(model_, q, X_BL);
  EXPECT_TRUE(X_BL.front().isApprox(Isometry3d::Identity(), 0));
  EXPECT_EQ((X_BL.back().matrix() - flange_pose(model_, q).matrix()).norm(), 0);
}

TEST_P(Kinematics, JacobianMatchesCentralDifferences) {
  constexpr double kStep = 1e-6;
  const Vector3d p_L(.03, -.05, .11);
  std::vector<Isometry3d> ahead(model_.links.size()), behind(model_.links.size());
  for (int n = 0; n < 50; ++n) {
    const JointVector q = test::random_q(model_, random_);
    for (int link = 0; link <= model_.dof(); ++link) {
      const Jacobian J = point_jacobian(model_, q, link, p_L);
      for (int i = 0; i < model_.dof(); ++i) {
        JointVector q_step = q;
        q_step(i) = q(i) + kStep;
        link_poses(model_, q_step, ahead);
        q_step(i) = q(i) - kStep;
        link_poses(model_, q_step, behind);
        const auto at = static_cast<std::size_t>(link);
        const Vector3d v = (ahead[at] * p_L - behind[at] * p_L) / (2 * kStep);
        const AngleAxisd turn(ahead[at].linear() * behind[at].linear().transpose());
        const Vector3d omega = turn.axis() * turn.angle() / (2 * kStep);
        ASSERT_LT((J.block<3, 1>(0, i) - v).norm(), 1e-8);
        ASSERT_LT((J.block<3, 1>(3, i) - omega).norm(), 1e-8);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Arms, Kinematics, testing::Bool(),
                         [](const auto& which) { return which.param ? "fanuc" : "motoman"; });

TEST(Home, ToolPointsDown) {
  const ArmModel fanuc = test::fanuc(), motoman = test::motoman();
  EXPECT_LT((flange_pose(fanuc, test::home(fanuc)).linear().col(0) + kZ).norm(), 1e-12);
  EXPECT_LT((flange_pose(motoman, test::home(motoman)).linear().col(2) + kZ).norm(), 1e-12);
}

}  // namespace
}  // namespace aprsim::robot
