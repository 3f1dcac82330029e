// Contact forces as torques on the joints, as the wrench at the tool, and as the operator's
// message.

#include "world/cell/robot/contact_loads.hpp"

#include <gtest/gtest.h>

#include "tests/unit/world/robot/test_arms.hpp"
#include "world/cell/robot/collision_stop.hpp"
#include "world/robot/kinematics/dynamics.hpp"

namespace aprsim::world {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Side = api::ContactSide;

class Loads : public testing::Test {
 protected:
  Loads() : X_WL(model.links.size()) {
    robot::link_poses(model, arm.q(), X_WL);
    for (Isometry3d& X : X_WL) X = X_WB * X;
  }
  /// On the flange's link, from a fixed body.
  [[nodiscard]] physics::ArmForce push(bool on_gripper) const {
    return {.link = model.dof(),
            .p_W = X_WL.back() * Vector3d(0, 0, 0.1),
            .f_W = {3, -5, 7},
            .partner = {Side::Kind::kFixed, 0},
            .on_gripper = on_gripper};
  }
  [[nodiscard]] ExternalTorque torque(const physics::ArmForce& force, bool has_tool = true) const {
    return external_torque(arm, X_WB, X_WL, {&force, 1}, has_tool);
  }

  robot::ArmModel model = robot::test::fanuc();
  robot::ServoArm arm{model, {}, {0, 0, -9.81}, robot::test::home(model), 1e-3};
  Isometry3d X_WB = Eigen::Translation3d(1, 2, 3) * Eigen::AngleAxisd(0.5, Vector3d::UnitZ());
  std::vector<Isometry3d> X_WL;
  api::CellDescription cell{.fixed = {"post"}};
};

TEST_F(Loads, TheTorquesDoTheWorkOfTheForce) {
  const physics::ArmForce force = push(false);
  const robot::JointVector tau = torque(force).all;
  const double h = 1e-7;
  for (int i = 0; i < model.dof(); ++i) {
    robot::JointVector q = arm.q();
    q(i) += h;
    const Vector3d moved = X_WB * robot::flange_pose(model, q) * Vector3d(0, 0, 0.1);
    EXPECT_NEAR(tau(i), force.f_W.dot(moved - force.p_W) / h, 1e-4) << i;
  }
}

TEST_F(Loads, OnlyBodiesOnTheGripperAreItsLoad) {
  physics::ArmForce force = push(true);
  EXPECT_GT(torque(force).all.norm(), 0);
  EXPECT_EQ(torque(force).load.norm(), 0);
  force.partner = {Side::Kind::kBody, 0};
  EXPECT_EQ(torque(force).load, torque(force).all);
  force.on_gripper = false;
  EXPECT_EQ(torque(force).load.norm(), 0);
}

TEST_F(Loads, RelayedForcesAndThoseOnAGripperThatIsOffLoadNothing) {
  EXPECT_EQ(torque(push(true), false).all.norm(), 0);
  EXPECT_GT(torque(push(false), false).all.norm(), 0);
  physics::ArmForce relayed = push(true);
  relayed.relayed = true;
  EXPECT_EQ(torque(relayed).all.norm(), 0);
}

TEST_F(Loads, TheToolsWrenchIsAboutItsPointInTheRobotsFrame) {
  const Isometry3d X_WR = X_WB * Eigen::AngleAxisd(0.3, Vector3d::UnitX());
  const Vector3d p_WT = X_WL.back() * Vector3d(0, 0, 0.3);
  const physics::ArmForce force = push(true);
  const ToolWrench wrench = tool_wrench(model.dof(), X_WR, p_WT, {&force, 1}, true);
  EXPECT_TRUE((X_WR.linear() * wrench.force_R).isApprox(force.f_W));
  EXPECT_TRUE((X_WR.linear() * wrench.torque_R).isApprox((force.p_W - p_WT).cross(force.f_W)));
  // Forces on other links do not count.
  EXPECT_EQ(tool_wrench(model.dof() - 1, X_WR, p_WT, {&force, 1}, true).force_R.norm(), 0);
}

TEST_F(Loads, ACollisionIsNamedByItsLargestContact) {
  physics::GripperState gripper;
  const auto message = [&](const std::vector<physics::ArmForce>& forces, bool has_tool = true) {
    return collision_message(arm, gripper, has_tool, forces, cell);
  };
  std::vector<physics::ArmForce> forces{push(true), push(false)};
  forces[1].f_W *= 2;
  forces[1].link = 2;
  EXPECT_EQ(message(forces), "");
  gripper.palm_deflection_m = 4e-3;
  const std::string why = message(forces);
  EXPECT_EQ(why.rfind("Protective stop: gripper mount deflected by 4.0 mm, limit 3.0 mm (", 0), 0u)
      << why;
  EXPECT_NE(why.find(model.links[2].name + " touches post with 18 N"), std::string::npos) << why;
  forces.pop_back();
  EXPECT_NE(message(forces).find("the gripper touches post with 9 N"), std::string::npos);
  EXPECT_EQ(message(forces, false), "") << "there is no mount to deflect";
}

TEST_F(Loads, TheGripOnAHeldBodyIsNoCollision) {
  physics::GripperState gripper;
  gripper.palm_deflection_m = 4e-3;
  gripper.held_body = 0;
  physics::ArmForce grip = push(true);
  grip.partner = {Side::Kind::kBody, 0};
  EXPECT_EQ(collision_message(arm, gripper, true, {&grip, 1}, cell).find("touches"),
            std::string::npos);
}

}  // namespace
}  // namespace aprsim::world
