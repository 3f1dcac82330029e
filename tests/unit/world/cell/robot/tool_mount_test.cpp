#include "world/cell/robot/tool_mount.hpp"

#include <gtest/gtest.h>

namespace aprsim::world {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

const Isometry3d kFlange(Eigen::Translation3d(1, 2, 3));

TEST(ToolMount, FollowsTheFlange) {
  ToolMount mount(2, Isometry3d::Identity());
  mount.step(kFlange);
  EXPECT_EQ(mount.X_WM().matrix(), kFlange.matrix());
  EXPECT_EQ(mount.tool(), 2);
}

TEST(ToolMount, ACoupledToolIsDrawnInEvenly) {
  ToolMount mount(-1, kFlange);
  EXPECT_FALSE(mount.has_tool());
  Isometry3d off = kFlange;
  off.translation() += Vector3d(2e-3, 0, 0);
  off.rotate(Eigen::AngleAxisd(0.04, Vector3d::UnitZ()));
  mount.couple(1, off);
  EXPECT_TRUE(mount.has_tool());
  EXPECT_EQ(mount.X_WM().matrix(), off.matrix());
  double before = 2e-3;
  for (int i = 0; i < 100; ++i) {
    mount.step(kFlange);
    const double left = (mount.X_WM().translation() - kFlange.translation()).norm();
    EXPECT_NEAR(before - left, 2e-5, 1e-12) << i;
    before = left;
  }
  EXPECT_TRUE(mount.X_WM().isApprox(kFlange, 1e-12));
}

TEST(ToolMount, AReleasedToolIsNoLongerDrawnIn) {
  ToolMount mount(-1, kFlange);
  mount.couple(1, Isometry3d::Identity());
  mount.release();
  EXPECT_EQ(mount.tool(), -1);
  mount.step(kFlange);
  EXPECT_EQ(mount.X_WM().matrix(), kFlange.matrix());
}

}  // namespace
}  // namespace aprsim::world
