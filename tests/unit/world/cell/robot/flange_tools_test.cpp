// The scene's tools on a flange: payloads, capture range, mount.

#include "world/cell/robot/flange_tools.hpp"

#include <gtest/gtest.h>

#include "world/cell/robot/tool_payload.hpp"

namespace aprsim::world {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

scene::Tool tool_of(double mass_kg, double force_n) {
  scene::Tool tool;
  tool.gripper.palm_mass_kg = mass_kg;
  tool.gripper.palm_size = {0.1, 0.1, 0.1};
  tool.gripper.force_n = force_n;
  tool.X_QT.p = {0, 0, 0.2};
  return tool;
}

class Flange : public testing::Test {
 protected:
  Flange() {
    robot.changer.mass_kg = 0.5;
    robot.changer.X_FQ = Pose{Vector3d(0, 0, 0.1), Eigen::Quaterniond::Identity()};
    robot.gripper.force_n = 40;
  }
  /// A tool whose coupling is `off` away from the flange's.
  [[nodiscard]] LooseTool loose(int tool, const Vector3d& off, double turn_rad = 0) const {
    LooseTool out;
    out.tool = tool;
    const Isometry3d X_WQ = X_WF * robot.changer.X_FQ->isometry() * Eigen::Translation3d(off) *
                            Eigen::AngleAxisd(turn_rad, Vector3d::UnitX());
    out.X_WT = X_WQ * tools[static_cast<std::size_t>(tool)].X_QT.isometry();
    return out;
  }

  scene::Robot robot;
  std::vector<scene::Tool> tools{tool_of(1, 60), tool_of(2, 80)};
  Isometry3d X_WF = Eigen::Translation3d(1, 2, 3) * Eigen::AngleAxisd(0.7, Vector3d::UnitY());
};

TEST_F(Flange, WithoutAToolOnlyTheChangerIsOnIt) {
  const FlangeTools flange(robot, tools);
  EXPECT_EQ(flange.payload(-1).mass_kg, 0.5);
  EXPECT_EQ(flange.payload(0).mass_kg, 1.5);
  EXPECT_EQ(flange.payload(1).mass_kg, 2.5);
  EXPECT_EQ(flange.full_grip_force_n(-1), 40);
  EXPECT_EQ(flange.full_grip_force_n(1), 80);
}

TEST_F(Flange, TheCommandedFrameIsTheToolsUnlessTheSceneFixesIt) {
  const auto setups = FlangeTools(robot, tools).setups();
  ASSERT_EQ(setups.size(), 2u);
  EXPECT_TRUE(setups[0].X_FT.translation().isApprox(Vector3d(0, 0, 0.3)));
  robot.tool_point_F = Pose{Vector3d(0.01, 0, 0), Eigen::Quaterniond::Identity()};
  EXPECT_TRUE(
      FlangeTools(robot, tools).setups()[0].X_FT.translation().isApprox(Vector3d(0.01, 0, 0)));
}

TEST_F(Flange, TakesTheNearestToolWithinItsCaptureRange) {
  const FlangeTools flange(robot, tools);
  const double range = robot.changer.capture_m;
  EXPECT_EQ(flange.within_capture(X_WF, {}), -1);
  const std::vector<LooseTool> far{loose(0, {0, 0, 1.1 * range})};
  EXPECT_EQ(flange.within_capture(X_WF, far), -1);
  const std::vector<LooseTool> both{loose(0, {0, 0, 0.9 * range}), loose(1, {0.5 * range, 0, 0})};
  EXPECT_EQ(flange.within_capture(X_WF, both), 1);
  const std::vector<LooseTool> turned{loose(0, {0, 0, 0.9 * range}),
                                      loose(1, {0, 0, 0}, 1.1 * robot.changer.capture_rad)};
  EXPECT_EQ(flange.within_capture(X_WF, turned), 0);
}

TEST_F(Flange, TheMountOfACoupledToolIsAtTheFlange) {
  const FlangeTools flange(robot, tools);
  EXPECT_TRUE(flange.mount_of(loose(1, Vector3d::Zero())).isApprox(X_WF, 1e-12));
}

TEST(ToolPayload, TwoBodiesJoinedHaveTheirCommonCentreAndInertia) {
  const robot::Payload a{.mass_kg = 1, .com_F = {0, 0, 0}};
  const robot::Payload b{.mass_kg = 3, .com_F = {0.4, 0, 0}};
  const robot::Payload sum = joined(a, b);
  EXPECT_DOUBLE_EQ(sum.mass_kg, 4);
  EXPECT_TRUE(sum.com_F.isApprox(Vector3d(0.3, 0, 0)));
  // Reduced mass times the distance's square, about both axes across it.
  const double inertia = 0.75 * 0.16;
  EXPECT_TRUE(sum.inertia_F.diagonal().isApprox(Vector3d(0, inertia, inertia)));
  // Nothing joined leaves the other as it is.
  EXPECT_EQ(joined({}, b).com_F, b.com_F);
}

}  // namespace
}  // namespace aprsim::world
