#include "world/physics/gripper/gripper_parts.hpp"

#include <gtest/gtest.h>

namespace aprsim::physics {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

scene::Gripper gripper() {
  scene::Gripper out;
  out.gap_open_m = 0.022;
  out.gap_closed_m = 0.002;
  return out;
}

const Isometry3d kX_WT = Eigen::Translation3d(0.5, -0.2, 1) *
                         Isometry3d(Eigen::AngleAxisd(0.6, Vector3d(1, 2, 3).normalized()));

TEST(GripperParts, FingersCloseTowardsEachOtherByTheirTravels) {
  GripperParts parts(gripper(), kX_WT);
  const Vector3d open_1 = parts.part(1).X_WS.translation();
  const Vector3d open_2 = parts.part(2).X_WS.translation();
  const double apart = (open_1 - open_2).norm();
  EXPECT_LT((parts.closing_W(0) + parts.closing_W(1)).norm(), 1e-12);
  parts.follow(kX_WT, {3e-3, 5e-3});
  EXPECT_LT((parts.part(1).X_WS.translation() - open_1 - 3e-3 * parts.closing_W(0)).norm(), 1e-12);
  EXPECT_LT((parts.part(2).X_WS.translation() - open_2 - 5e-3 * parts.closing_W(1)).norm(), 1e-12);
  EXPECT_NEAR((parts.part(1).X_WS.translation() - parts.part(2).X_WS.translation()).norm(),
              apart - 8e-3, 1e-12);
}

TEST(GripperParts, TheToolFrameIsWhereThePalmReallyIs) {
  GripperParts parts(gripper(), Isometry3d::Identity());
  parts.follow(kX_WT, {0, 0});
  EXPECT_LT((parts.X_WT().matrix() - kX_WT.matrix()).norm(), 1e-12);
  const Isometry3d X_WS = Eigen::Translation3d(0, 0, 1e-3) * parts.part(0).X_WS;
  parts.place(0, X_WS.linear(), X_WS.translation());
  EXPECT_NEAR(parts.X_WT().translation().z(), kX_WT.translation().z() + 1e-3, 1e-12);
}

TEST(GripperParts, OutsideTheCellNothingMeetsThem) {
  GripperParts parts(gripper(), kX_WT);
  const Aabb everywhere{Vector3d::Constant(-1e3), Vector3d::Constant(1e3)};
  EXPECT_TRUE(parts.bounds().meets(everywhere));
  parts.follow_removed(kX_WT, {0, 0});
  EXPECT_FALSE(parts.bounds().meets(everywhere));
  for (int i = 0; i < GripperParts::kColliding; ++i) {
    EXPECT_FALSE(parts.part(i).bounds.meets(everywhere));
  }
  parts.follow(kX_WT, {0, 0});
  EXPECT_TRUE(parts.bounds().meets(everywhere));
}

TEST(GripperParts, ALeverThatIsHeldMovesWithTheTool) {
  GripperParts parts(gripper(), Isometry3d::Identity());
  const int lever = static_cast<int>(GripperParts::kLever);
  const Eigen::Matrix3d turned(Eigen::AngleAxisd(0.3, Vector3d::UnitZ()));
  parts.place(GripperParts::kLever, turned, parts.part(lever).X_WS.translation());
  const Isometry3d before = parts.part(lever).X_WS;
  parts.hold_lever(Isometry3d::Identity());
  parts.place_lever(kX_WT);
  EXPECT_LT((parts.part(lever).X_WS.matrix() - (kX_WT * before).matrix()).norm(), 1e-12);
}

}  // namespace
}  // namespace aprsim::physics
