// A robot's reaction to contact in stepped time: protective stop, retreat and compliance; the tool
// changer; saved states.

#include "world/cell/machines/simulated_robot.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/cell_script.hpp"
#include "tests/support/pick_place.hpp"
#include "world/robot/kinematics/dynamics.hpp"

namespace aprsim::test {
namespace {

using api::ActionState;
using Eigen::Vector3d;

constexpr int kFanuc = 0, kMotoman = 1;

struct Collision {
  int touch_step = -1, trip_step = -1;
  double q_touch = 0, q_deepest = 0;
};

/// Swings joint 1 so that the forearm runs into a post that only one of two equal cells has.
class SwingIntoPost : public testing::TestWithParam<int> {
 protected:
  static std::shared_ptr<const scene::Scene> with_post(int robot) {
    auto scene = *load_scene("aprs");
    const auto& base = scene.robots[static_cast<std::size_t>(robot)].X_WB;
    const double angle = 0.6, radius = robot == kFanuc ? 0.35 : 0.4;
    Pose X_WS;
    X_WS.p = base.p + base.q * Vector3d(radius * std::cos(angle), radius * std::sin(angle),
                                        robot == kFanuc ? 0.69 : 0.90);
    scene.fixed.push_back({"post", {0.05, 0.05, 0.3}, X_WS});
    return std::make_shared<const scene::Scene>(std::move(scene));
  }
};

TEST_P(SwingIntoPost, StopsWithinTenMillisecondsAndBacksOff) {
  const int robot = GetParam();
  const auto r = static_cast<std::size_t>(robot);
  CellScript blocked(with_post(robot)), open(load_scene("aprs"));
  const double home = open.now.robots[r].joints[0].position_rad;
  for (CellScript* cell : {&blocked, &open}) cell->act(robot, api::InitRobot{});
  const api::MoveJoints swing{
      {{.joint = 0, .position_rad = home + 1, .speed_rad_s = 1.0, .accel_rad_s2 = 3}}};
  for (CellScript* cell : {&blocked, &open}) {
    cell->world.apply(100, api::RobotCommand{robot, swing});
  }
  Collision seen;
  for (int step = 0; step < 3000 && seen.trip_step < 0; ++step) {
    blocked.advance();
    open.advance();
    const auto& one = blocked.now.robots[r];
    const double q = one.joints[0].position_rad;
    if (seen.touch_step < 0 && q != open.now.robots[r].joints[0].position_rad) {
      seen.touch_step = step;
      seen.q_touch = q;
    }
    if (one.protective_stop) seen.trip_step = step;
  }
  ASSERT_GE(seen.touch_step, 0);
  ASSERT_GE(seen.trip_step, 0);
  EXPECT_LE(seen.trip_step - seen.touch_step, 10);
  const auto& now = blocked.now.robots[r];
  EXPECT_EQ(now.action.state, ActionState::kError);
  const std::string& why = now.action.description;
  EXPECT_EQ(why.rfind("Protective stop: ", 0), 0u) << why;
  EXPECT_NE(why.find("touches post with "), std::string::npos) << why;
  EXPECT_NE(why.find(" N); the arm backs off by itself; send InitCanon"), std::string::npos) << why;
  EXPECT_FALSE(now.initialized);

  for (int i = 0; i < 3500; ++i) {
    blocked.advance();
    seen.q_deepest = std::max(seen.q_deepest, now.joints[0].position_rad);
  }
  // A few millimetres clear of the post, at rest, with nothing pressing.
  EXPECT_LT(now.joints[0].position_rad, seen.q_touch - 0.002 / 0.4);
  EXPECT_GT(now.joints[0].position_rad, seen.q_touch - 0.04);
  EXPECT_LT(seen.q_deepest, seen.q_touch + 0.03);
  EXPECT_FALSE(now.moving);
  const double rest = now.joints[0].position_rad;
  blocked.advance(100);
  EXPECT_EQ(now.joints[0].position_rad, rest);
  EXPECT_EQ(now.joints[0].velocity_rad_s, 0);
  EXPECT_EQ(now.action.description, why);

  blocked.act(robot, api::InitRobot{});
  blocked.act(robot, api::MoveJoints{{{.joint = 0, .position_rad = home}}});
  EXPECT_EQ(now.joints[0].position_rad, home);
}
TEST_P(SwingIntoPost, PressesWithTheTorqueThatItIsGiven) {
  const int robot = GetParam();
  CellScript cell(with_post(robot));
  const auto& now = cell.now.robots[static_cast<std::size_t>(robot)];
  cell.act(robot, api::InitRobot{});
  const double home = now.joints[0].position_rad, torque = robot == kFanuc ? 20 : 60;
  cell.act(robot, api::MoveJoints{{{.joint = 0, .position_rad = home + 0.1}}});
  double most = 0;
  cell.each_step = [&] { most = std::max(most, std::abs(now.joints[0].torque_nm)); };
  cell.act(robot,
           api::MoveJoints{{{.joint = 0,
                             .position_rad = home + 1.2,
                             .speed_rad_s = {},
                             .accel_rad_s2 = {},
                             .torque = api::JointTorque{torque, {}}}}},
           120);
  EXPECT_FALSE(now.protective_stop) << now.action.description;
  EXPECT_NE(now.action.description.find("is held at"), std::string::npos);
  cell.advance(1000);
  // The axis is vertical: nothing but the post loads it. Friction bears its share of 4 %.
  const double friction =
      0.04 *
      cell.world.description()->robots[static_cast<std::size_t>(robot)].joints[0].max_torque_nm;
  EXPECT_NEAR(now.joints[0].torque_nm + friction, torque, 0.15 * torque);
  EXPECT_LT(most, 2 * torque);
}

INSTANTIATE_TEST_SUITE_P(Robots, SwingIntoPost, testing::Values(kFanuc, kMotoman),
                         [](const auto& robot) {
                           return robot.param == kFanuc ? "fanuc" : "motoman";
                         });

TEST(GripperOnTable, StopsBeforeTheMountIsCrushedAndBacksOff) {
  CellScript cell(load_scene("aprs"));
  const auto& description = cell.world.description()->robots[kMotoman];
  const Eigen::Isometry3d X_RW =
      (description.X_WB.isometry() * description.X_BR.isometry()).inverse();
  cell.act(kMotoman, api::InitRobot{});
  const auto tool_at = [&](double z) { return Pose::from(X_RW * tool_down({0.5, 0.5, z}, 0)); };
  cell.act(kMotoman, api::MoveTo{tool_at(1.05), false});
  std::string why;
  try {
    cell.act(kMotoman, api::MoveTo{tool_at(0.85), true});
  } catch (const std::runtime_error& error) {
    why = error.what();
  }
  EXPECT_NE(why.find("the gripper touches optical_table with "), std::string::npos) << why;
  const auto& now = cell.now.robots[kMotoman];
  EXPECT_LT(now.gripper.palm_deflection_m, 5e-3);
  cell.advance(2000);
  EXPECT_FALSE(now.moving);
  EXPECT_LT(now.gripper.palm_deflection_m, 1e-4);
  EXPECT_LT(now.force_T_R.norm(), 0.5);
  cell.act(kMotoman, api::InitRobot{});
  cell.act(kMotoman, api::MoveTo{tool_at(1.05), true});
}

/// The robots of the scene by themselves, pushed by hand.
class Pushed : public testing::TestWithParam<int> {
 protected:
  Pushed()
      : scene(load_scene("aprs")),
        model(*robot::load_arm_model(robot().model_file)),
        cell(*scene, static_cast<std::size_t>(GetParam()), model) {
    cell.apply(1, {GetParam(), api::InitRobot{}});
    step(20);
  }
  const scene::Robot& robot() const { return scene->robots[static_cast<std::size_t>(GetParam())]; }
  void step(int count, const Vector3d& push_W = Vector3d::Zero()) {
    for (; count > 0; --count) {
      forces.clear();
      if (push_W.norm() > 0) {
        forces.push_back({.link = model.dof(),
                          .p_W = snapshot().X_WT.p,
                          .f_W = push_W,
                          .partner = {api::ContactSide::Kind::kFixed, 0},
                          .on_gripper = true});
      }
      cell.step(gripper, forces, description, {});
    }
  }
  api::RobotSnapshot snapshot() const {
    api::RobotSnapshot out;
    cell.write(gripper, forces, out);
    return out;
  }
  std::vector<double> joints() const {
    std::vector<double> out;
    for (const auto& joint : snapshot().joints) out.push_back(joint.position_rad);
    return out;
  }
  std::shared_ptr<const scene::Scene> scene;
  robot::ArmModel model;
  world::SimulatedRobot cell;
  physics::GripperState gripper;
  std::vector<physics::ArmForce> forces;
  api::CellDescription description{.fixed = {"hand"}};
};
INSTANTIATE_TEST_SUITE_P(Robots, Pushed, testing::Values(kFanuc, kMotoman), [](const auto& robot) {
  return robot.param == kFanuc ? "fanuc" : "motoman";
});

TEST_P(Pushed, YieldsAFewMillimetresTo50NAndReturnsExactly) {
  const auto before = joints();
  const Vector3d p = snapshot().X_WT.p;
  double furthest = 0;
  for (int i = 0; i < 300; ++i) {
    step(1, {0, 50, 0});
    furthest = std::max(furthest, (snapshot().X_WT.p - p).norm());
  }
  EXPECT_GT(furthest, 2e-4);
  EXPECT_LT(furthest, 8e-3);
  EXPECT_FALSE(snapshot().protective_stop);
  EXPECT_EQ(snapshot().action.state, ActionState::kDone);
  step(2500);
  EXPECT_EQ(joints(), before);
}

TEST_P(Pushed, AStateSavedInMidMotionGoesOnBitForBit) {
  cell.apply(2, {GetParam(), api::MoveJoints{{{.joint = 0, .position_rad = 0.5}}}});
  step(250);
  step(30, {0, 60, 0});
  const world::SimulatedRobot::State saved = cell.save();
  const auto go_on = [&](world::SimulatedRobot& which) {
    std::vector<double> path;
    for (int i = 0; i < 600; ++i) {
      if (i == 300) which.apply(3, {GetParam(), api::StopMotion{api::StopKind::kNormal}});
      which.step(gripper, {}, description, {});
      api::RobotSnapshot out;
      which.write(gripper, {}, out);
      for (const auto& joint : out.joints) {
        path.push_back(joint.position_rad);
        path.push_back(joint.torque_nm);
      }
    }
    return path;
  };
  const auto first = go_on(cell);
  cell.restore(saved);
  EXPECT_EQ(go_on(cell), first);
  world::SimulatedRobot other(*scene, static_cast<std::size_t>(GetParam()), model);
  other.restore(saved);
  EXPECT_EQ(go_on(other), first);
}

TEST(DrivesOff, TheBrakesBearTheArmUntilItNextMoves) {
  CellScript cell(load_scene("fanuc_only"));
  const auto& now = cell.now.robots[kFanuc];
  cell.act(kFanuc, api::InitRobot{});
  EXPECT_GT(std::abs(now.joints[1].torque_nm), 1) << "the drive bears the arm's weight";
  cell.act(kFanuc, api::StopMotion{api::StopKind::kFast});
  const auto held = now.joints;
  cell.advance(998);
  EXPECT_TRUE(now.drives_on);
  cell.advance(2000);
  EXPECT_FALSE(now.drives_on);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(now.joints[i].torque_nm, 0);
    EXPECT_EQ(now.joints[i].position_rad, held[i].position_rad);
  }
  cell.act(kFanuc, api::MoveJoints{{{.joint = 0, .position_rad = held[0].position_rad + 0.1}}});
  EXPECT_TRUE(now.drives_on);
  EXPECT_GT(std::abs(now.joints[1].torque_nm), 1);
}

// The ratio of the tool's speed to its angular velocity when one joint moves alone.
TEST(ToolLever, IsTheDistanceOfTheToolFromTheAxis) {
  CellScript cell(load_scene("motoman_only"));
  const auto& now = cell.now.robots[0];
  cell.act(0, api::InitRobot{});
  for (int joint = 0; joint < 7; ++joint) {
    const auto& moved = now.joints[static_cast<std::size_t>(joint)];
    int compared = 0;
    cell.each_step = [&] {
      if (std::abs(moved.velocity_rad_s) < 0.01) return;
      EXPECT_NEAR(now.v_RT.norm(), moved.tool_lever_m * std::abs(moved.velocity_rad_s), 1e-6);
      ++compared;
    };
    cell.act(0, api::MoveJoints{{{.joint = joint, .position_rad = moved.position_rad + 0.1}}});
    EXPECT_GT(compared, 10) << "joint " << joint + 1;
  }
}

TEST(ToolPoint, ARobotWithOneToolPointKeepsIt) {
  auto scene = *load_scene("aprs");
  Pose tool_point;
  tool_point.p = {0.05, 0, 0};
  scene.robots[kFanuc].tool_point_F = tool_point;
  CellScript cell(std::make_shared<const scene::Scene>(scene));
  const auto& now = cell.now.robots[kFanuc];
  cell.act(kFanuc, api::InitRobot{});
  const robot::ArmModel model = *robot::load_arm_model(scene.robots[kFanuc].model_file);
  robot::JointVector q(model.dof());
  for (int i = 0; i < model.dof(); ++i) {
    q(i) = now.joints[static_cast<std::size_t>(i)].position_rad;
  }
  const Eigen::Isometry3d X_RT = scene.robots[kFanuc].X_BR.isometry().inverse() *
                                 robot::flange_pose(model, q) * tool_point.isometry();
  EXPECT_LT((now.X_RT.p - X_RT.translation()).norm(), 1e-12);
  const Pose before = now.X_RT;
  cell.act(kFanuc, api::SetToolChanger{true});
  EXPECT_FALSE(now.tool_mounted);
  EXPECT_EQ(now.X_RT.p, before.p);
  Pose above = before;
  above.p.z() += 0.1;
  cell.act(kFanuc, api::MoveTo{above, true});
  EXPECT_LT((now.X_RT.p - above.p).norm(), 1e-9);
  EXPECT_TRUE(cell.world.description()->robots[kFanuc].tool_point_F);
}

}  // namespace
}  // namespace aprsim::test
