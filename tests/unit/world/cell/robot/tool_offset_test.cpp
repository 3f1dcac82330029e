#include "world/cell/robot/tool_offset.hpp"

#include <gtest/gtest.h>

namespace aprsim::world {
namespace {

using Eigen::Vector3d;

RobotFaults offset_faults() {
  RobotFaults faults;
  faults.base_offset =
      Pose{Vector3d(0.01, 0, 0), Eigen::Quaterniond(Eigen::AngleAxisd(0.1, Vector3d::UnitZ()))};
  faults.tool_offset = Pose{Vector3d(0, 0, 0.02), Eigen::Quaterniond::Identity()};
  return faults;
}

const Pose kGoal{Vector3d(0.5, 0.2, 0.3),
                 Eigen::Quaterniond(Eigen::AngleAxisd(3, Vector3d::UnitX()))};

bool same(const Pose& a, const Pose& b) { return a.isometry().isApprox(b.isometry(), 1e-12); }

TEST(ToolOffset, ReportsThePoseThatWasCommanded) {
  const ToolOffset offset(offset_faults());
  const api::RobotAction moved = offset.displaced(api::MoveTo{kGoal, true});
  const auto& to = std::get<api::MoveTo>(moved);
  EXPECT_GT((to.X_RT.p - kGoal.p).norm(), 0.01);
  EXPECT_TRUE(to.straight);
  EXPECT_TRUE(same(offset.reported(to.X_RT), kGoal));
}

TEST(ToolOffset, DisplacesEveryPoseOfACommand) {
  const ToolOffset offset(offset_faults());
  const auto through =
      std::get<api::MoveThroughTo>(offset.displaced(api::MoveThroughTo{{{kGoal}, {kGoal}}, true}));
  for (const api::Waypoint& point : through.waypoints) {
    EXPECT_TRUE(same(offset.reported(point.X_RT), kGoal));
  }
  api::MoveScrew screw;
  screw.start = api::Waypoint{kGoal};
  screw.axis_point_R = Vector3d(1, 0, 0);
  const auto turned = std::get<api::MoveScrew>(offset.displaced(screw));
  EXPECT_TRUE(same(offset.reported(turned.start->X_RT), kGoal));
  EXPECT_TRUE(
      turned.axis_point_R->isApprox(offset_faults().base_offset.isometry() * Vector3d(1, 0, 0)));
}

TEST(ToolOffset, LeavesCommandsOfJointsAlone) {
  const api::RobotAction move = api::MoveJoints{{{.joint = 0, .position_rad = 0.5}}};
  const auto same_move = std::get<api::MoveJoints>(ToolOffset(offset_faults()).displaced(move));
  EXPECT_EQ(same_move.targets[0].position_rad, 0.5);
}

}  // namespace
}  // namespace aprsim::world
