#include "world/physics/gripper/mount_motion.hpp"

#include <gtest/gtest.h>

namespace aprsim::physics {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kMountStep = 1e-3;

TEST(MountMotion, IsAtRestUntilItIsToldOtherwise) {
  const MountMotion mount = MountMotion::at_rest(Isometry3d(Eigen::Translation3d(1, 2, 3)));
  EXPECT_TRUE(mount.velocity_at({4, 5, 6}, kMountStep).isZero(0));
  EXPECT_TRUE(mount.omega_W.isZero(0));
}

TEST(MountMotion, TakesWhatItCarriesToTheNextPoseInOneStep) {
  const Isometry3d X_WT = Eigen::Translation3d(1, 2, 3) * Eigen::AngleAxisd(0.4, Vector3d::UnitX());
  const Isometry3d X_next = Eigen::Translation3d(1.001, 2, 3) *
                            Eigen::AngleAxisd(0.002, Vector3d::UnitZ()) *
                            Eigen::AngleAxisd(0.4, Vector3d::UnitX());
  MountMotion mount = MountMotion::at_rest(X_WT);
  mount.begin_step(X_next, kMountStep);
  EXPECT_LT((mount.omega_W - Vector3d(0, 0, 2)).norm(), 1e-9);
  const Vector3d p_T(0.1, -0.2, 0.3);
  const Vector3d p_W = X_WT * p_T;
  EXPECT_LT((p_W + kMountStep * mount.velocity_at(p_W, kMountStep) - X_next * p_T).norm(), 1e-12);
  mount.end_step();
  EXPECT_EQ(mount.X_WT.matrix(), X_next.matrix());
}

}  // namespace
}  // namespace aprsim::physics
