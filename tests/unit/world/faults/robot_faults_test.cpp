// The effect of each fault of a robot and its gripper, and its end.

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/unit/world/faults/fault_cell.hpp"

namespace aprsim::test {
namespace {

using namespace std::chrono_literals;

double yaw_of(const Eigen::Isometry3d& X) { return std::atan2(X(1, 0), X(0, 0)); }

/// About the robot's z, of where the tool is against where it is said to be.
double yaw_error(const FaultCell& cell) {
  return yaw_of(cell.true_X_RT(kFanucArm) * cell.robot(kFanucArm).X_RT.isometry().inverse());
}

/// No command is carried out while the fault lasts; afterwards InitCanon helps.
void expect_out_of_order(FaultCell& cell, int index, std::uint64_t fault, const std::string& why) {
  EXPECT_EQ(cell.robot(index).action.state, api::ActionState::kError);
  EXPECT_NE(cell.robot(index).action.description.find(why), std::string::npos)
      << cell.robot(index).action.description;
  const double q = cell.robot(index).joints[0].position_rad;
  EXPECT_THROW(cell.act(index, api::InitRobot{}), std::runtime_error);
  EXPECT_THROW(cell.act(index, turn(0, q + 0.1)), std::runtime_error);
  cell.end(fault);
  cell.advance();
  EXPECT_THROW(cell.act(index, turn(0, q + 0.1)), std::runtime_error) << "before InitCanon";
  cell.act(index, api::InitRobot{});
  cell.act(index, turn(0, q + 0.05));
  EXPECT_NEAR(cell.robot(index).joints[0].position_rad, q + 0.05, 1e-9);
}

TEST(RobotFaults, ABreakdownStopsTheArmAtOnceAndRefusesAll) {
  FaultCell cell;
  cell.act(kFanucArm, api::InitRobot{});
  const double q = cell.robot(kFanucArm).joints[0].position_rad;
  cell.tell(kFanucArm, turn(0, q + 1));
  cell.advance(400);
  ASSERT_TRUE(cell.robot(kFanucArm).moving);
  const auto id = cell.inject("robot-breakdown", "fanuc");
  cell.advance(300);
  EXPECT_EQ(cell.fault(id).state, api::FaultState::kActive);
  EXPECT_FALSE(cell.robot(kFanucArm).moving);
  EXPECT_FALSE(cell.robot(kFanucArm).drives_on);
  cell.act(kMotomanArm, api::InitRobot{});
  expect_out_of_order(cell, kFanucArm, id, "broken down");
}

TEST(RobotFaults, ADriveFaultNamesItsJoint) {
  FaultCell cell;
  cell.act(kFanucArm, api::InitRobot{});
  const auto id = cell.inject("drive-fault", "fanuc:3");
  cell.advance(10);
  EXPECT_FALSE(cell.robot(kFanucArm).drives_on);
  expect_out_of_order(cell, kFanucArm, id, "joint 3");
}

TEST(RobotFaults, AnEmergencyStopOfOneRobotBrakesOnThePath) {
  FaultCell cell;
  for (const int robot : {kFanucArm, kMotomanArm}) cell.act(robot, api::InitRobot{});
  const double q = cell.robot(kFanucArm).joints[0].position_rad;
  cell.tell(kFanucArm, turn(0, q + 1));
  cell.advance(600);
  ASSERT_GT(cell.robot(kFanucArm).joints[0].velocity_rad_s, 0.3);
  const auto id = cell.inject("robot-emergency-stop", "fanuc");
  cell.advance();
  EXPECT_GT(cell.robot(kFanucArm).joints[0].velocity_rad_s, 0.1) << "brakes, does not jump to rest";
  cell.advance(500);
  EXPECT_EQ(cell.robot(kFanucArm).joints[0].velocity_rad_s, 0);
  EXPECT_FALSE(cell.robot(kFanucArm).drives_on);
  cell.act(kMotomanArm, turn(0, cell.robot(kMotomanArm).joints[0].position_rad + 0.05));
  expect_out_of_order(cell, kFanucArm, id, "emergency stop");
}

TEST(RobotFaults, TheCellsEmergencyStopStopsAll) {
  FaultCell cell;
  for (const int robot : {kFanucArm, kMotomanArm}) cell.act(robot, api::InitRobot{});
  cell.run_belt(0.1);
  cell.advance(500);
  ASSERT_NEAR(cell.now.conveyor.speed_m_s, 0.1, 1e-9);
  const auto id = cell.inject("cell-emergency-stop");
  cell.advance(500);
  EXPECT_EQ(cell.now.conveyor.speed_m_s, 0);
  EXPECT_EQ(cell.now.conveyor.fault, api::DriveFault::kEmergencyStop);
  EXPECT_TRUE(cell.now.conveyor.emergency_stop);
  EXPECT_FALSE(cell.robot(kMotomanArm).drives_on);
  const api::ConveyorCommand reset{.fault_reset = true};
  cell.world.apply(1, reset);
  cell.run_belt(0.1);
  cell.advance(100);
  EXPECT_EQ(cell.now.conveyor.speed_m_s, 0) << "pressed still";
  expect_out_of_order(cell, kFanucArm, id, "cell's emergency stop");
  EXPECT_FALSE(cell.now.conveyor.emergency_stop);
  cell.world.apply(2, reset);
  cell.run_belt(0.1);
  cell.advance(500);
  EXPECT_NEAR(cell.now.conveyor.speed_m_s, 0.1, 1e-9);
}

TEST(RobotFaults, ARebootHoldsTheArmUntilItIsOver) {
  FaultCell cell;
  cell.act(kMotomanArm, api::InitRobot{});
  const auto id = cell.inject("controller-reboot", "motoman", {}, SimTime(2s));
  cell.advance(10);
  EXPECT_FALSE(cell.robot(kMotomanArm).drives_on);
  EXPECT_FALSE(cell.robot(kMotomanArm).initialized);
  EXPECT_THROW(cell.act(kMotomanArm, api::InitRobot{}), std::runtime_error);
  cell.advance(2000);
  EXPECT_EQ(cell.fault(id).state, api::FaultState::kEnded);
  EXPECT_FALSE(cell.robot(kMotomanArm).initialized);
  cell.act(kMotomanArm, api::InitRobot{});
}

TEST(RobotFaults, AProtectiveStopIsOverWithInitCanon) {
  FaultCell cell;
  cell.act(kFanucArm, api::InitRobot{});
  const auto id = cell.inject("protective-stop", "fanuc");
  cell.advance();
  EXPECT_TRUE(cell.robot(kFanucArm).protective_stop);
  EXPECT_EQ(cell.fault(id).state, api::FaultState::kEnded);
  EXPECT_EQ(cell.fault(id).begin_step, cell.fault(id).end_step);
  cell.act(kFanucArm, api::InitRobot{});
  EXPECT_FALSE(cell.robot(kFanucArm).protective_stop);
}

TEST(RobotFaults, ASlowRobotMovesAtItsShareAndGoesOnAtFullSpeed) {
  FaultCell cell;
  cell.act(kFanucArm, api::InitRobot{});
  const double q = cell.robot(kFanucArm).joints[0].position_rad;
  const auto id = cell.inject("robot-slow", "fanuc", {{"share", 0.3}});
  cell.advance();
  cell.tell(kFanucArm, turn(0, q + 1, 0.5));
  cell.advance(1000);
  EXPECT_NEAR(cell.robot(kFanucArm).joints[0].velocity_rad_s, 0.15, 1e-6);
  EXPECT_EQ(cell.robot(kFanucArm).override_fraction, 1) << "it says that it is at full speed";
  cell.end(id);
  cell.advance(600);
  EXPECT_NEAR(cell.robot(kFanucArm).joints[0].velocity_rad_s, 0.5, 1e-6);
}

TEST(RobotFaults, AWeakJointCannotHoldTheArm) {
  FaultCell cell;
  cell.act(kFanucArm, api::InitRobot{});
  cell.advance(10);
  // The joint that bears most, left half of what it needs.
  int joint = 0;
  double most = 0;
  for (int i = 0; i < 6; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const double share = std::abs(cell.robot(kFanucArm).joints[at].torque_nm) /
                         cell.description(kFanucArm).joints[at].max_torque_nm;
    if (share > most) joint = i;
    most = std::max(most, share);
  }
  ASSERT_GT(most, 0.02);
  const double q = cell.robot(kFanucArm).joints[static_cast<std::size_t>(joint)].position_rad;
  const auto id =
      cell.inject("joint-weak", "fanuc:" + std::to_string(joint + 1), {{"share", 0.5 * most}});
  for (int i = 0; i < 1000 && !cell.robot(kFanucArm).protective_stop; ++i) cell.advance();
  const auto& sagged = cell.robot(kFanucArm).joints[static_cast<std::size_t>(joint)];
  EXPECT_GT(std::abs(sagged.position_rad - q), 1e-3) << "sags";
  EXPECT_TRUE(cell.robot(kFanucArm).protective_stop);
  cell.end(id);
  cell.advance(2000);
  cell.act(kFanucArm, api::InitRobot{});
  cell.act(kFanucArm, turn(joint, q));
  EXPECT_NEAR(cell.robot(kFanucArm).joints[static_cast<std::size_t>(joint)].position_rad, q, 1e-9);
}

TEST(RobotFaults, WithBacklashTheLinkStaysBehind) {
  FaultCell cell;
  cell.act(kFanucArm, api::InitRobot{});
  const double q = cell.robot(kFanucArm).joints[0].position_rad;
  const auto id = cell.inject("joint-backlash", "fanuc:1", {{"width", 0.02}});
  cell.advance(200);
  cell.act(kFanucArm, turn(0, q + 0.2));
  EXPECT_NEAR(yaw_error(cell), -0.01, 1e-6);
  cell.act(kFanucArm, turn(0, q));
  EXPECT_NEAR(yaw_error(cell), 0.01, 1e-6);
  cell.end(id);
  cell.advance(200);
  EXPECT_NEAR(yaw_error(cell), 0, 1e-12);
}

TEST(RobotFaults, ABiasedEncoderReportsWhatIsNot) {
  FaultCell cell;
  cell.act(kFanucArm, api::InitRobot{});
  const double q = cell.robot(kFanucArm).joints[0].position_rad;
  const auto id = cell.inject("encoder-bias", "fanuc:1", {{"angle", 0.02}});
  cell.advance(50);
  EXPECT_NEAR(yaw_error(cell), -0.01, 1e-3) << "at a moderate speed";
  cell.advance(100);
  EXPECT_NEAR(yaw_error(cell), -0.02, 1e-9);
  EXPECT_EQ(cell.robot(kFanucArm).joints[0].position_rad, q);
  cell.end(id);
  cell.advance(200);
  EXPECT_NEAR(yaw_error(cell), 0, 1e-12);
}

TEST(RobotFaults, AWrongBaseFrameMovesTheToolElsewhere) {
  FaultCell cell;
  cell.act(kFanucArm, api::InitRobot{});
  Pose target = cell.robot(kFanucArm).X_RT;
  const auto id = cell.inject("base-offset", "fanuc", {{"x", 0.01}, {"yaw", 0.05}});
  cell.advance();
  target.p.z() -= 0.02;
  cell.act(kFanucArm, api::MoveTo{target, true});
  EXPECT_LT((cell.robot(kFanucArm).X_RT.p - target.p).norm(), 1e-6) << "so it says";
  const Eigen::Vector3d meant =
      Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitZ()) * target.p + Eigen::Vector3d(0.01, 0, 0);
  EXPECT_LT((cell.true_X_RT(kFanucArm).translation() - meant).norm(), 1e-6);
  cell.end(id);
  cell.advance();
  EXPECT_LT(cell.error(kFanucArm).translation().norm(), 1e-9);
  cell.act(kFanucArm, api::MoveTo{target, true});
  EXPECT_LT((cell.true_X_RT(kFanucArm).translation() - target.p).norm(), 1e-6);
}

TEST(RobotFaults, AWrongToolFrameMovesTheToolElsewhere) {
  FaultCell cell;
  cell.act(kFanucArm, api::InitRobot{});
  Pose target = cell.robot(kFanucArm).X_RT;
  const auto id = cell.inject("tool-offset", "fanuc", {{"z", -0.005}, {"y", 0.003}});
  cell.advance();
  target.p.z() -= 0.02;
  cell.act(kFanucArm, api::MoveTo{target, true});
  EXPECT_LT((cell.robot(kFanucArm).X_RT.p - target.p).norm(), 1e-6);
  const Eigen::Vector3d off = target.isometry().inverse() * cell.true_X_RT(kFanucArm).translation();
  EXPECT_LT((off - Eigen::Vector3d(0, 0.003, -0.005)).norm(), 1e-6);
  cell.end(id);
  cell.advance();
  EXPECT_LT(cell.error(kFanucArm).translation().norm(), 1e-9);
}

// ---- grippers

double grip_force(const FaultCell& cell) {
  const auto& force = cell.robot(kFanucArm).gripper.force_n;
  return std::min(force[0], force[1]);
}

TEST(GripperFaults, PressureLossLoosensTheGrip) {
  FaultCell cell;
  cell.grasp("part_large_gear_1");
  cell.advance(500);
  const double before = grip_force(cell);
  ASSERT_GT(before, 1);
  const auto id = cell.inject("gripper-pressure-loss", "fanuc", {{"share", 0.3}});
  cell.advance(300);
  EXPECT_LT(grip_force(cell), 0.5 * before);
  cell.end(id);
  cell.advance(500);
  EXPECT_GT(grip_force(cell), 0.9 * before);
}

TEST(GripperFaults, ALeakLoosensItSlowly) {
  FaultCell cell;
  cell.grasp("part_large_gear_1");
  cell.advance(500);
  const double before = grip_force(cell);
  const auto id = cell.inject("gripper-leak", "fanuc", {{"share", 0.2}, {"over", 2}});
  cell.advance(200);
  const double soon = grip_force(cell);
  EXPECT_GT(soon, 0.75 * before);
  cell.advance(1000);
  const double later = grip_force(cell);
  EXPECT_LT(later, 0.7 * before);
  cell.advance(1200);
  EXPECT_LT(grip_force(cell), 0.5 * later + 0.1 * before);
  EXPECT_EQ(cell.robot(kFanucArm).gripper.max_force_n, cell.description(kFanucArm).gripper.force_n)
      << "the pressure that is set";
  cell.end(id);
  cell.advance(500);
  EXPECT_GT(grip_force(cell), 0.9 * before);
}

TEST(GripperFaults, StuckOpenDropsWhatItHolds) {
  FaultCell cell;
  cell.grasp("part_large_gear_1");
  const auto id = cell.inject("gripper-stuck-open", "fanuc");
  cell.advance(800);
  const auto& gripper = cell.robot(kFanucArm).gripper;
  const double open = cell.description(kFanucArm).gripper.gap_open_m;
  EXPECT_FALSE(gripper.holding);
  EXPECT_NEAR(gripper.separation_m, open, 1e-4);
  EXPECT_EQ(gripper.setting, 0) << "so it was told";
  cell.act(kFanucArm, api::SetGripper{0});
  EXPECT_NEAR(gripper.separation_m, open, 1e-4) << "whatever it is told";
  cell.end(id);
  cell.advance(800);
  EXPECT_LT(gripper.separation_m, 0.5 * open);
}

TEST(GripperFaults, StuckClosedDoesNotOpen) {
  FaultCell cell;
  cell.act(kFanucArm, api::InitRobot{});
  const auto id = cell.inject("gripper-stuck-closed", "fanuc");
  cell.advance(800);
  const auto& gripper = cell.robot(kFanucArm).gripper;
  const auto& about = cell.description(kFanucArm).gripper;
  EXPECT_NEAR(gripper.separation_m, about.gap_closed_m, 1e-4);
  cell.act(kFanucArm, api::SetGripper{1});
  EXPECT_NEAR(gripper.separation_m, about.gap_closed_m, 1e-4);
  cell.end(id);
  cell.advance(800);
  EXPECT_NEAR(gripper.separation_m, about.gap_open_m, 1e-4);
}

TEST(GripperFaults, ASlowFingerTakesLonger) {
  const auto steps_to_close = [](FaultCell& cell) {
    cell.tell(kFanucArm, api::SetGripper{0});
    const double closed = cell.description(kFanucArm).gripper.gap_closed_m;
    int steps = 0;
    while (cell.robot(kFanucArm).gripper.separation_m > closed + 1e-4 && steps < 20000) {
      cell.advance();
      ++steps;
    }
    return steps;
  };
  FaultCell cell;
  cell.act(kFanucArm, api::InitRobot{});
  const int usual = steps_to_close(cell);
  cell.act(kFanucArm, api::SetGripper{1});
  const auto id = cell.inject("gripper-slow-finger", "fanuc", {{"share", 0.1}, {"finger", 2}});
  cell.advance(10);
  EXPECT_GT(steps_to_close(cell), 3 * usual);
  cell.end(id);
  cell.act(kFanucArm, api::SetGripper{1});
  EXPECT_LT(steps_to_close(cell), 1.2 * usual);
}

TEST(GripperFaults, WornPadsLetAGearSlip) {
  const auto sinks_by = [](bool worn) {
    FaultCell cell;
    cell.grasp("part_large_gear_1");
    cell.advance(200);
    const double before = cell.X_WB("part_large_gear_1").translation().z();
    if (worn) cell.inject("gripper-worn-pads", "fanuc", {{"share", 0.0}});
    cell.advance(1000);
    return before - cell.X_WB("part_large_gear_1").translation().z();
  };
  EXPECT_LT(sinks_by(false), 1e-4);
  EXPECT_GT(sinks_by(true), 5e-3);
}

TEST(GripperFaults, WornPadsAreAsBeforeWhenItEnds) {
  FaultCell cell;
  const auto id = cell.inject("gripper-worn-pads", "fanuc", {{"share", 0.0}}, SimTime(1s));
  cell.advance(1100);
  EXPECT_EQ(cell.fault(id).state, api::FaultState::kEnded);
  cell.grasp("part_large_gear_1");
  cell.advance(200);
  const double before = cell.X_WB("part_large_gear_1").translation().z();
  cell.advance(1000);
  EXPECT_NEAR(cell.X_WB("part_large_gear_1").translation().z(), before, 1e-4);
}

TEST(GripperFaults, AGripperThatDropsOpensByItself) {
  FaultCell cell;
  cell.grasp("part_large_gear_1");
  const auto id = cell.inject("gripper-drops", "fanuc", {{"after", 0.5}, {"open", 1}});
  cell.advance(450);
  EXPECT_TRUE(cell.robot(kFanucArm).gripper.holding);
  cell.advance(500);
  EXPECT_FALSE(cell.robot(kFanucArm).gripper.holding);
  const auto& about = cell.description(kFanucArm).gripper;
  EXPECT_GT(cell.robot(kFanucArm).gripper.separation_m, 0.9 * about.gap_open_m);
  cell.advance(1500);
  EXPECT_NEAR(cell.robot(kFanucArm).gripper.separation_m, about.gap_closed_m, 1e-4)
      << "as it is told";
  cell.end(id);
  cell.advance();
  EXPECT_EQ(cell.fault(id).state, api::FaultState::kEnded);
}

}  // namespace
}  // namespace aprsim::test
