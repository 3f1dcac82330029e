// Tool changes of a robot in its cell, in stepped time.

#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/cell_script.hpp"
#include "tests/support/pick_place.hpp"

namespace aprsim::test {
namespace {

using api::ActionState;
using Eigen::Vector3d;

constexpr int kWithChanger = 0;

/// A recorded pose of the tool point in the robot's frame.
Pose recorded(double x_mm, double y_mm, double z_mm, double rx_deg, double ry_deg, double rz_deg) {
  const double deg = M_PI / 180;
  Pose pose;
  pose.p = Vector3d(x_mm, y_mm, z_mm) / 1000;
  pose.q = Eigen::AngleAxisd(rz_deg * deg, Vector3d::UnitZ()) *
           Eigen::AngleAxisd(ry_deg * deg, Vector3d::UnitY()) *
           Eigen::AngleAxisd(rx_deg * deg, Vector3d::UnitX());
  return pose;
}

Pose above(Pose pose, double by_m) {
  pose.p.z() += by_m;
  return pose;
}

/// The laboratory's Fanuc, at its recorded poses of nearLeftHolder.
class AtHolder : public testing::Test {
 protected:
  AtHolder() {
    cell_.act(kWithChanger, api::InitRobot{});
    cell_.act(kWithChanger, api::MoveTo{approach_, false});
    cell_.act(kWithChanger, api::MoveTo{holder_, true});
  }
  [[nodiscard]] const api::RobotSnapshot& robot() const { return cell_.now.robots[kWithChanger]; }
  [[nodiscard]] const api::ToolSnapshot& pincher() const { return cell_.now.tools[0]; }

  CellScript cell_{load_scene("aprs_lab")};
  Pose holder_ = recorded(-113.97587585449219, -364.081787109375, 22.058918999267578,
                          -179.80863952636707, 0.8590714931492976, 141.3236846923828);
  Pose approach_ = recorded(-115.4185791015625, -362.2852783203125, 172.04119873046875,
                            -179.8086395263673, 0.8590722084038638, 141.32369995117188);
};

TEST_F(AtHolder, TheToolIsLeftInItAndTakenAgain) {
  ASSERT_EQ(robot().tool, 0);
  const Pose reported = robot().X_RT;
  cell_.act(kWithChanger, api::SetToolChanger{true});
  EXPECT_EQ(robot().tool, -1);
  EXPECT_FALSE(robot().tool_mounted);
  EXPECT_EQ(pincher().robot, -1);
  EXPECT_EQ(robot().X_RT.p, reported.p) << "one tool point";
  const Vector3d left = pincher().X_WT.p;
  cell_.act(kWithChanger, api::MoveTo{approach_, true});
  cell_.advance(500);
  EXPECT_TRUE(pincher().resting);
  EXPECT_LT((pincher().X_WT.p - left).norm(), 1.5e-3);
  // Closed up here it takes nothing, and nothing moves.
  cell_.act(kWithChanger, api::SetToolChanger{false});
  EXPECT_EQ(robot().action.description, "nothing taken: no tool is at the flange");
  EXPECT_EQ(robot().tool, -1);
  cell_.act(kWithChanger, api::SetToolChanger{true});
  // Two millimetres aside and a degree turned: the lock draws it in.
  Pose aside = holder_;
  aside.p += Vector3d(0.0015, -0.0015, 0);
  aside.q = Eigen::AngleAxisd(M_PI / 180, Vector3d::UnitZ()) * aside.q;
  cell_.act(kWithChanger, api::MoveTo{above(aside, 0.1), false});
  cell_.act(kWithChanger, api::MoveTo{aside, true});
  cell_.act(kWithChanger, api::SetToolChanger{false});
  EXPECT_EQ(robot().tool, 0);
  EXPECT_EQ(pincher().robot, kWithChanger);
  cell_.act(kWithChanger, api::MoveTo{above(aside, 0.1), true});
  cell_.advance(200);
  const auto& description = *cell_.world.description();
  const auto& arm = description.robots[kWithChanger];
  const Eigen::Isometry3d X_WF = arm.X_WB.isometry() * arm.X_BR.isometry() *
                                 robot().X_RT.isometry() * arm.tool_point_F->isometry().inverse();
  const Eigen::Isometry3d X_WT = X_WF * arm.X_FQ.isometry() * description.tools[0].X_QT.isometry();
  EXPECT_LT((pincher().X_WT.p - X_WT.translation()).norm(), 1e-5);
  EXPECT_FALSE(robot().protective_stop);
  EXPECT_EQ(cell_.now.physics_faults, 0u);
}

TEST_F(AtHolder, OutOfTheCaptureRangeNothingIsTaken) {
  cell_.act(kWithChanger, api::SetToolChanger{true});
  Pose aside = holder_;
  aside.p.x() += 0.007;
  aside.p.z() += 0.002;
  cell_.act(kWithChanger, api::MoveTo{aside, true});
  cell_.act(kWithChanger, api::SetToolChanger{false});
  EXPECT_EQ(robot().tool, -1);
  EXPECT_THROW(cell_.act(kWithChanger, api::SetGripper{0}), std::runtime_error);
  EXPECT_NE(robot().action.description.find("no tool is on the robot"), std::string::npos);
}

// Sent without a pause they are done in their order, each in its time.
TEST_F(AtHolder, OpenCloseAndGripperBackToBack) {
  std::uint64_t opened = 0, closed = 0;
  cell_.each_step = [&] {
    if (opened == 0 && robot().tool < 0) opened = cell_.now.step;
    if (opened != 0 && closed == 0 && robot().tool == 0) closed = cell_.now.step;
  };
  const std::uint64_t begun = cell_.now.step;
  cell_.world.apply(1001, api::RobotCommand{kWithChanger, api::SetToolChanger{true}, {}});
  cell_.world.apply(1002, api::RobotCommand{kWithChanger, api::SetToolChanger{false}, {}});
  cell_.world.apply(1003, api::RobotCommand{kWithChanger, api::SetGripper{0}, {}});
  bool done = false;
  for (int i = 0; i < 3000 && !done; ++i) {
    cell_.advance();
    ASSERT_NE(robot().action.state, ActionState::kError) << robot().action.description;
    EXPECT_EQ(robot().action.ticket, 1003u);
    done = robot().action.state == ActionState::kDone;
  }
  EXPECT_TRUE(done);
  EXPECT_NEAR(static_cast<double>(opened - begun), 200, 5);
  EXPECT_NEAR(static_cast<double>(closed - opened), 200, 5);
  EXPECT_EQ(robot().tool, 0);
  EXPECT_NEAR(robot().gripper.separation_m, 0.005, 1e-4);
  EXPECT_FALSE(robot().protective_stop);
}

TEST_F(AtHolder, AMoveWaitsForTheLock) {
  cell_.world.apply(1001, api::RobotCommand{kWithChanger, api::SetToolChanger{true}, {}});
  cell_.act(kWithChanger, api::MoveTo{above(holder_, 0.1), true});
  EXPECT_EQ(robot().tool, -1);
  EXPECT_LT((robot().X_RT.p - above(holder_, 0.1).p).norm(), 1e-6);
  cell_.advance(500);
  EXPECT_TRUE(pincher().resting) << "it was not dragged along";
}

TEST_F(AtHolder, AStopDropsWhatWaitsAndNotTheLock) {
  cell_.world.apply(1001, api::RobotCommand{kWithChanger, api::SetToolChanger{true}, {}});
  cell_.advance(20);
  cell_.world.apply(1002, api::RobotCommand{kWithChanger, api::MoveTo{approach_, true}, {}});
  cell_.act(kWithChanger, api::StopMotion{});
  const Pose here = robot().X_RT;
  cell_.advance(600);
  EXPECT_EQ(robot().tool, -1);
  EXPECT_EQ(robot().X_RT.p, here.p);
}

TEST_F(AtHolder, SavedInTheMiddleItGoesOnBitForBit) {
  cell_.world.apply(1001, api::RobotCommand{kWithChanger, api::SetToolChanger{true}, {}});
  cell_.world.apply(1002, api::RobotCommand{kWithChanger, api::SetToolChanger{false}, {}});
  cell_.world.apply(1003, api::RobotCommand{kWithChanger, api::MoveTo{approach_, true}, {}});
  cell_.advance(300);
  const world::WorldState state = cell_.world.save();
  cell_.advance(1500);
  const std::uint64_t expected = cell_.world.state_hash();
  EXPECT_EQ(robot().tool, 0);
  CellScript fresh(load_scene("aprs_lab"));
  fresh.world.restore(state);
  fresh.advance(1500);
  EXPECT_EQ(fresh.world.state_hash(), expected);
  cell_.world.restore(state);
  cell_.advance(1500);
  EXPECT_EQ(cell_.world.state_hash(), expected);
}

TEST(ToolChanger, OpenedInTheAirTheGripperFalls) {
  CellScript cell(load_scene("aprs"));
  const auto& now = cell.now.robots[kWithChanger];
  const auto& tool = cell.now.tools[kWithChanger];
  ASSERT_EQ(now.tool, kWithChanger);
  cell.act(kWithChanger, api::InitRobot{});
  const double height = tool.X_WT.p.z();
  const double torque = now.joints[1].torque_nm;
  const Pose with_tool = now.X_RT;
  // Back to back: it is gone before the lock closes.
  cell.world.apply(1001, api::RobotCommand{kWithChanger, api::SetToolChanger{true}, {}});
  cell.act(kWithChanger, api::SetToolChanger{false});
  EXPECT_EQ(now.action.description, "nothing taken: no tool is at the flange");
  cell.advance(2000);
  EXPECT_EQ(now.tool, -1);
  EXPECT_EQ(tool.robot, -1);
  EXPECT_LT(tool.X_WT.p.z(), height - 0.05);
  EXPECT_LT(std::abs(now.joints[1].torque_nm), std::abs(torque)) << "the arm carries less";
  EXPECT_GT((now.X_RT.p - with_tool.p).norm(), 0.05) << "the flange's pose, without a tool point";
  EXPECT_TRUE(now.force_T_R.isZero());
  EXPECT_FALSE(now.protective_stop);
}

TEST(ToolChanger, HeldPartFallsWithTheGripper) {
  CellScript cell(load_scene("aprs"));
  const auto& now = cell.now.robots[kWithChanger];
  const std::string gear = "part_large_gear_1";
  const auto& description = cell.world.description()->robots[kWithChanger];
  const Eigen::Isometry3d X_RW =
      (description.X_WB.isometry() * description.X_BR.isometry()).inverse();
  const double grip_z = cell.world.description()->bodies[cell.body(gear)].disc_height_m + 0.004;
  const Vector3d at = cell.X_WB(gear).translation() + Vector3d(0, 0, grip_z);
  const auto move = [&](double up, bool straight) {
    cell.act(kWithChanger,
             api::MoveTo{Pose::from(X_RW * tool_down(at + Vector3d(0, 0, up), 0)), straight});
  };
  cell.act(kWithChanger, api::InitRobot{});
  move(0.06, false);
  move(0, true);
  cell.act(kWithChanger, api::SetGripper{0});
  move(0.12, true);
  ASSERT_TRUE(now.gripper.holding);
  const double height = cell.X_WB(gear).translation().z();
  cell.act(kWithChanger, api::SetToolChanger{true});
  EXPECT_FALSE(now.gripper.holding);
  EXPECT_EQ(now.gripper.held_body, -1);
  cell.advance(3000);
  EXPECT_LT(cell.X_WB(gear).translation().z(), height - 0.05);
  EXPECT_TRUE(cell.now.world_fault.empty());
}

}  // namespace
}  // namespace aprsim::test
