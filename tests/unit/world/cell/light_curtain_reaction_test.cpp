// The light curtain in the whole cell: what breaks it, what it stops, how that is reset.

#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/cell_script.hpp"

namespace aprsim::test {
namespace {

/// The default cell with its curtain moved to an upright plane and told to react.
std::shared_ptr<const scene::Scene> cell_with(api::CurtainReaction reaction) {
  scene::Scene scene = *load_scene("aprs");
  scene.light_curtain->reaction = reaction;
  return std::make_shared<const scene::Scene>(std::move(scene));
}

/// Somebody who stands 1.2 m from the emitters, in the curtain's plane.
api::SetIntruder person(double y = -1.75) {
  api::Intruder intruder;
  intruder.X_WI.p = {0, y, 0.9};
  intruder.size_m = {0.5, 0.3, 1.8};
  return {intruder};
}

api::MoveJoints turn_joint(int joint, double to_rad) {
  return {{{.joint = joint, .position_rad = to_rad, .speed_rad_s = 1.0, .accel_rad_s2 = {}}}};
}

TEST(LightCurtainInTheCell, TheCellAtRestLeavesItClear) {
  for (const char* name : {"aprs", "aprs_2024"}) {
    CellScript cell(load_scene(name));
    ASSERT_TRUE(cell.world.description()->light_curtain.has_value());
    EXPECT_FALSE(cell.now.light_curtain.broken);
    EXPECT_EQ(cell.now.light_curtain.distance_m[0], 2.4);
    EXPECT_EQ(cell.now.light_curtain.distance_m[37], 2.4);
  }
}

TEST(LightCurtainInTheCell, AnIntruderShowsAtOnceWithItsDistance) {
  CellScript cell(load_scene("aprs"));
  cell.world.apply(1, person());
  cell.world.write(cell.now);
  EXPECT_TRUE(cell.now.light_curtain.broken) << "before any further step";
  ASSERT_TRUE(cell.now.intruder.has_value());
  for (std::size_t i = 0; i < 38; ++i) {
    EXPECT_NEAR(cell.now.light_curtain.distance_m[i], 0.95, 1e-12) << "beam " << i;
  }
  cell.world.apply(2, person(-2.0));
  cell.world.write(cell.now);
  EXPECT_FALSE(cell.now.light_curtain.broken) << "one step back";
  cell.world.apply(3, api::SetIntruder{});
  cell.world.write(cell.now);
  EXPECT_FALSE(cell.now.intruder.has_value());
}

TEST(LightCurtainInTheCell, NoReactionStopsNothing) {
  CellScript cell(cell_with(api::CurtainReaction::kNone));
  cell.world.apply(1, api::ConveyorCommand{.run = true, .forward = true, .speed_m_s = 0.1});
  cell.act(0, api::InitRobot{});
  cell.world.apply(2, person());
  cell.advance(300);
  EXPECT_TRUE(cell.now.light_curtain.broken);
  EXPECT_NEAR(cell.now.conveyor.speed_m_s, 0.1, 1e-12);
  EXPECT_FALSE(cell.now.robots[0].protective_stop);
}

TEST(LightCurtainInTheCell, BeltStopHoldsUntilClearAndReset) {
  CellScript cell(cell_with(api::CurtainReaction::kBeltStop));
  const api::ConveyorCommand run{.run = true, .forward = true, .speed_m_s = 0.1};
  cell.world.apply(1, run);
  cell.act(0, api::InitRobot{});
  cell.advance(300);
  cell.world.apply(2, person());
  cell.advance(60);
  EXPECT_EQ(cell.now.conveyor.speed_m_s, 0) << "0.1 m/s at 2 m/s^2";
  EXPECT_EQ(cell.now.conveyor.fault, api::DriveFault::kLightCurtain);
  EXPECT_FALSE(cell.now.robots[0].protective_stop) << "the robots go on";
  const api::ConveyorCommand reset{.fault_reset = true};
  cell.world.apply(3, reset);
  cell.world.apply(4, run);
  cell.advance(100);
  EXPECT_EQ(cell.now.conveyor.speed_m_s, 0);
  cell.world.apply(5, api::SetIntruder{});
  cell.world.apply(6, run);
  cell.advance(100);
  EXPECT_EQ(cell.now.conveyor.speed_m_s, 0) << "clear, not reset";
  cell.world.apply(7, reset);
  cell.world.apply(8, run);
  cell.advance(300);
  EXPECT_NEAR(cell.now.conveyor.speed_m_s, 0.1, 1e-12);
}

TEST(LightCurtainInTheCell, ProtectiveStopBrakesBothRobotsUntilInitCanon) {
  CellScript cell(cell_with(api::CurtainReaction::kProtectiveStop));
  for (const int robot : {0, 1}) cell.act(robot, api::InitRobot{});
  cell.world.apply(100, api::ConveyorCommand{.run = true, .forward = true, .speed_m_s = 0.1});
  const double start = cell.now.robots[0].joints[0].position_rad;
  cell.world.apply(101, api::RobotCommand{0, turn_joint(0, start + 1.0)});
  cell.advance(400);
  ASSERT_GT(cell.now.robots[0].joints[0].velocity_rad_s, 0.5) << "in full motion";
  cell.world.apply(102, person());
  cell.advance();
  for (const auto& robot : cell.now.robots) {
    EXPECT_TRUE(robot.protective_stop);
    EXPECT_EQ(robot.action.state, api::ActionState::kError);
    EXPECT_NE(robot.action.description.find("light curtain"), std::string::npos);
  }
  EXPECT_GT(cell.now.robots[0].joints[0].velocity_rad_s, 0.1) << "brakes, does not jump to rest";
  cell.advance(500);
  EXPECT_EQ(cell.now.robots[0].joints[0].velocity_rad_s, 0);
  EXPECT_FALSE(cell.now.robots[0].moving);
  EXPECT_NEAR(cell.now.conveyor.speed_m_s, 0.1, 1e-12) << "the belt goes on";
  const double stopped = cell.now.robots[0].joints[0].position_rad;

  EXPECT_THROW(cell.act(0, api::InitRobot{}), std::runtime_error) << "still broken";
  EXPECT_TRUE(cell.now.robots[0].protective_stop);
  cell.world.apply(103, api::SetIntruder{});
  cell.advance(50);
  EXPECT_TRUE(cell.now.robots[0].protective_stop) << "clear, not initialised";
  cell.act(0, api::InitRobot{});
  EXPECT_FALSE(cell.now.robots[0].protective_stop);
  EXPECT_TRUE(cell.now.robots[1].protective_stop) << "each by its own InitCanon";
  cell.act(0, turn_joint(0, start));
  EXPECT_LT(cell.now.robots[0].joints[0].position_rad, stopped);
}

TEST(LightCurtainInTheCell, AllStopsBeltAndRobots) {
  CellScript cell(cell_with(api::CurtainReaction::kAll));
  cell.world.apply(1, api::ConveyorCommand{.run = true, .forward = true, .speed_m_s = 0.1});
  cell.advance(300);
  cell.world.apply(2, person());
  cell.advance(200);
  EXPECT_EQ(cell.now.conveyor.speed_m_s, 0);
  EXPECT_TRUE(cell.now.robots[0].protective_stop);
  EXPECT_TRUE(cell.now.robots[1].protective_stop);
}

TEST(LightCurtainInTheCell, AnArmThatSwingsThroughBreaksIt) {
  scene::Scene scene = *load_scene("aprs");
  // A short curtain beside the Fanuc, which turns its arm into it.
  CellScript before(load_scene("aprs"));
  const Eigen::Vector3d tool = before.now.robots[0].X_WT.p;
  api::LightCurtainDescription& curtain = *scene.light_curtain;
  curtain.X_WK.p = {tool.x() - 0.6, tool.y() + 0.25, tool.z() - 0.1};
  curtain.beams = 30;
  curtain.pitch_m = 0.02;
  curtain.range_m = 1.2;
  CellScript cell(std::make_shared<const scene::Scene>(std::move(scene)));
  ASSERT_FALSE(cell.now.light_curtain.broken);
  cell.act(0, api::InitRobot{});
  const double start = cell.now.robots[0].joints[0].position_rad;
  cell.world.apply(50, api::RobotCommand{0, turn_joint(0, start + 1.2)});
  bool broken = false;
  cell.each_step = [&] { broken = broken || cell.now.light_curtain.broken; };
  cell.advance(2500);
  EXPECT_TRUE(broken);
}

TEST(LightCurtainInTheCell, ATrayOnTheBeltBreaksABeamAcrossIt) {
  scene::Scene scene = *load_scene("empty_belt");
  api::LightCurtainDescription curtain;  // straight across the belt, 10 mm above it, two beams
  curtain.X_WK.p = {-0.9, -0.35, 0.919};
  curtain.X_WK.q = Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ());
  curtain.beams = 2;
  curtain.pitch_m = 0.02;
  curtain.range_m = 0.7;
  scene.light_curtain = curtain;
  CellScript cell(std::make_shared<const scene::Scene>(std::move(scene)));
  EXPECT_FALSE(cell.now.light_curtain.broken);
  cell.world.apply(1, api::ConveyorCommand{.run = true, .forward = true, .speed_m_s = 0.3});
  double first_broken_x = NAN;
  cell.each_step = [&] {
    if (std::isnan(first_broken_x) && cell.now.light_curtain.broken) {
      first_broken_x = cell.now.bodies[0].X_WB.p.x();
      EXPECT_EQ(cell.now.light_curtain.distance_m[1], 0.7) << "above the slab";
      EXPECT_LT(cell.now.light_curtain.distance_m[0], 0.35);
    }
  };
  cell.advance(1500);
  const double half = cell.world.description()->bodies[0].box_max.x();
  // Looked at every 10 ms: 3 mm of belt.
  EXPECT_NEAR(first_broken_x + half, -0.9, 0.0035);
}

TEST(LightCurtainInTheCell, TheSameCommandsGiveTheSameReadings) {
  const auto run = [] {
    CellScript cell(cell_with(api::CurtainReaction::kAll));
    cell.act(0, api::InitRobot{});
    cell.world.apply(7, person());
    cell.advance(100);
    return std::pair(cell.now.light_curtain.distance_m, cell.world.state_hash());
  };
  EXPECT_EQ(run(), run());
}

}  // namespace
}  // namespace aprsim::test
