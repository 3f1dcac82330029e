// The load of a held part as a robot's clients see it: force sensor, joint torques and mount; and
// the report of a collision of that part.

#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/cell_script.hpp"
#include "tests/support/pick_place.hpp"
#include "world/robot/kinematics/dynamics.hpp"

namespace aprsim::test {
namespace {

using Eigen::Vector3d;

constexpr double kWeight_n = 0.8 * 9.81;
constexpr double kTable_m = 0.1;  // height of its top

/// The Fanuc alone, its base turned, with a heavy gear on a table.
std::shared_ptr<const scene::Scene> scene_with_heavy_gear() {
  auto scene = *load_scene("fanuc_only");
  scene.robots[0].X_WB.q = Eigen::AngleAxisd(0.5, Vector3d::UnitZ());
  Pose X_WS;
  X_WS.p = {0.4, 0, 0.5 * kTable_m};
  scene.fixed.push_back({"table", {0.3, 0.3, kTable_m}, X_WS});
  scene::GearType gear;
  gear.name = "heavy";
  gear.disc_radius_m = 0.03;
  gear.disc_height_m = 0.006;
  gear.hub_top_radius_m = gear.hub_bottom_radius_m = 0.01;
  gear.hub_height_m = 0.006;
  gear.peg_radius_m = 0.0038;
  gear.peg_top_m = 0.024;
  gear.mass_kg = kWeight_n / 9.81;
  scene.gear_types["heavy"] = gear;
  Pose X_WP;
  X_WP.p = {0.4, 0, kTable_m + gear.hub_height_m};
  scene.gears.push_back({"gear", "heavy", X_WP});
  return std::make_shared<const scene::Scene>(std::move(scene));
}

class HeldLoad : public testing::Test {
 protected:
  HeldLoad() : cell(scene_with_heavy_gear()) {
    const auto& description = cell.world.description()->robots[0];
    X_WR = description.X_WB.isometry() * description.X_BR.isometry();
    cell.act(0, api::InitRobot{});
    grip = cell.X_WB("gear").translation() + Vector3d(0, 0, 0.01);
    move({0, 0, 0.15}, false);
    cell.act(0, api::SetMotionLimit{api::MotionLimit::kTransSpeed, false, 0.1});
    cell.act(0, api::SetMotionLimit{api::MotionLimit::kTransAccel, false, 1});
  }
  /// To the grip's place and so far from it.
  void move(const Vector3d& off, bool straight = true) {
    cell.act(0, api::MoveTo{Pose::from(X_WR.inverse() * tool_down(grip + off, 0.3)), straight});
  }
  void pick() {
    move({0, 0, 0});
    cell.act(0, api::SetGripper{0});
    cell.act(0, api::Dwell{std::chrono::milliseconds(100)});
    ASSERT_TRUE(robot().gripper.holding);
    move({0, 0, 0.15});
    cell.advance(1500);
  }
  const api::RobotSnapshot& robot() const { return cell.now.robots[0]; }

  CellScript cell;
  Eigen::Isometry3d X_WR;
  Vector3d grip;
};

TEST_F(HeldLoad, WeightShowsInForceSensorJointTorquesAndMount) {
  cell.advance(500);
  const auto before = robot();
  EXPECT_EQ(before.force_T_R, Vector3d::Zero());
  pick();
  const auto& now = robot();
  ASSERT_FALSE(now.protective_stop) << now.action.description;
  ASSERT_TRUE(now.gripper.holding);
  EXPECT_EQ(now.gripper.held_body, static_cast<int>(cell.body("gear")));
  // In the robot's frame, downwards; about the tool point by the lever of the gear.
  const Vector3d weight_R = X_WR.linear().transpose() * Vector3d(0, 0, -kWeight_n);
  EXPECT_LT((now.force_T_R - weight_R).norm(), 0.01 * kWeight_n);
  const Vector3d lever_W = cell.X_WB("gear").translation() - now.X_WT.p;
  const Vector3d moment_R = X_WR.linear().transpose() * lever_W.cross(Vector3d(0, 0, -kWeight_n));
  EXPECT_LT((now.torque_T_R - moment_R).norm(), 0.002 * kWeight_n);
  const double sag = kWeight_n / load_scene("fanuc_only")->robots[0].gripper.palm_stiffness_n_m;
  EXPECT_NEAR(now.gripper.palm_deflection_m, sag, 0.03 * sag);
  // The principle of virtual work gives the torques, against the torques at the same place without
  // it.
  const auto model = *robot::load_arm_model(load_scene("fanuc_only")->robots[0].model_file);
  robot::JointVector q(model.dof()), change(model.dof());
  for (int i = 0; i < model.dof(); ++i) {
    const auto joint = static_cast<std::size_t>(i);
    q(i) = now.joints[joint].position_rad;
    EXPECT_NEAR(q(i), before.joints[joint].position_rad, 1e-5);
    change(i) = now.joints[joint].torque_nm - before.joints[joint].torque_nm;
  }
  const Eigen::Isometry3d X_WB = cell.world.description()->robots[0].X_WB.isometry();
  const Vector3d p_F =
      robot::flange_pose(model, q).inverse() * (X_WB.inverse() * cell.X_WB("gear").translation());
  const robot::JointVector expected =
      -(robot::point_jacobian(model, q, model.dof(), p_F).topRows<3>().transpose() *
        (X_WB.linear().transpose() * Vector3d(0, 0, -kWeight_n)));
  EXPECT_GT(expected.cwiseAbs().maxCoeff(), 2);
  EXPECT_LT((change - expected).cwiseAbs().maxCoeff(), 0.02 * expected.cwiseAbs().maxCoeff());
  // Let go, all is as before.
  cell.act(0, api::SetGripper{1});
  cell.advance(1500);
  EXPECT_EQ(robot().force_T_R, Vector3d::Zero());
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(robot().joints[i].torque_nm, before.joints[i].torque_nm, 1e-4);
  }
}

TEST_F(HeldLoad, InertiaAddsInMotion) {
  pick();
  double most = 0, least = 1e9;
  cell.each_step = [&] {
    const double up = -(X_WR.linear() * robot().force_T_R).z();
    most = std::max(most, up);
    least = std::min(least, up);
  };
  cell.act(0, api::SetMotionLimit{api::MotionLimit::kTransSpeed, false, 0.5});
  cell.act(0, api::SetMotionLimit{api::MotionLimit::kTransAccel, false, 3});
  move({0, 0, 0.25});
  cell.each_step = nullptr;
  ASSERT_FALSE(robot().protective_stop) << robot().action.description;
  // m (g + a) on the way up, m (g - a) while braking, with what the mount's spring adds.
  EXPECT_GT(most, 0.8 * (9.81 + 1.5));
  EXPECT_LT(most, 0.8 * (9.81 + 4.5));
  EXPECT_LT(least, 0.8 * (9.81 - 1.5));
  EXPECT_GT(least, 0.8 * (9.81 - 4.5));
}

// The held part is pressed onto the table: the stop tells what it met, not what is held.
TEST_F(HeldLoad, ACollisionOfTheHeldPartNamesWhatItMet) {
  pick();
  std::string why;
  try {
    move({0, 0, -0.02});
  } catch (const std::runtime_error& error) {
    why = error.what();
  }
  EXPECT_NE(why.find("the gripper touches table with "), std::string::npos) << why;
}

}  // namespace
}  // namespace aprsim::test
