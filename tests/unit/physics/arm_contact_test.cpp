#include <cmath>

#include <gtest/gtest.h>

#include "tests/unit/physics/cell_builder.hpp"

namespace aprsim::physics::test {
namespace {

/// An arm of links 0..n-1 that float where the test puts them, with one shape on link `link`.
struct FloatingArm {
  robot::ArmModel model;
  std::vector<Eigen::Isometry3d> X_WL;
};

FloatingArm floating_arm(int links, int link, robot::LinkShape shape, const Eigen::Vector3d& at) {
  FloatingArm arm;
  arm.model.joints.resize(static_cast<std::size_t>(links) - 1);
  arm.model.links.resize(static_cast<std::size_t>(links));
  arm.model.links[static_cast<std::size_t>(link)].collision.push_back(std::move(shape));
  Eigen::Isometry3d far = Eigen::Isometry3d::Identity();
  far.translation().z() = 5;  // gripper and other links out of the way
  arm.X_WL.assign(static_cast<std::size_t>(links), far);
  arm.X_WL[static_cast<std::size_t>(link)].translation() = at;
  return arm;
}

robot::LinkShape capsule(double radius, double length) {
  robot::LinkShape shape;
  shape.shape = robot::CapsuleShape{radius, length};
  return shape;
}

Eigen::Vector3d sum(std::span<const ArmForce> forces) {
  Eigen::Vector3d total = Eigen::Vector3d::Zero();
  for (const auto& force : forces) total += force.f_W;
  return total;
}

class ArmWorld {
 public:
  ArmWorld(scene::Scene the_scene, std::vector<FloatingArm> arms) : scene(std::move(the_scene)) {
    for (auto& arm : arms) {
      models.push_back(arm.model);
      X_WL.push_back(arm.X_WL);
    }
    world = std::make_unique<PhysicsWorld>(scene, models, X_WL);
  }
  void move(int robot, int link, const Eigen::Vector3d& delta, int steps) {
    auto& poses = X_WL[static_cast<std::size_t>(robot)];
    for (int i = 0; i < steps; ++i) {
      poses[static_cast<std::size_t>(link)].translation() += delta / steps;
      world->set_arm(robot, poses);
      world->step();
    }
  }
  scene::Scene scene;
  std::vector<robot::ArmModel> models;
  std::vector<std::vector<Eigen::Isometry3d>> X_WL;
  std::unique_ptr<PhysicsWorld> world;
};

TEST(ArmContact, LinkPressedIntoATableIsPushedBack) {
  auto scene = empty_scene();
  add_table(scene);
  add_hand(scene, {0, 0, 1});
  ArmWorld arm(std::move(scene), {floating_arm(3, 1, capsule(0.05, 0.2), {0, 0, 0.16})});
  arm.world->step();
  EXPECT_TRUE(arm.world->arm_forces(0).empty());
  arm.move(0, 1, {0, 0, -0.011}, 100);
  arm.world->step();  // at rest, 1 mm deep
  ASSERT_FALSE(arm.world->arm_forces(0).empty());
  EXPECT_EQ(arm.world->arm_forces(0)[0].link, 1);
  EXPECT_EQ(arm.world->arm_forces(0)[0].with, "table");
  EXPECT_NEAR(sum(arm.world->arm_forces(0)).z(), 100, 1);  // 1e5 N/m
  arm.move(0, 1, {0, 0, 0.005}, 10);
  EXPECT_TRUE(arm.world->arm_forces(0).empty());
}

TEST(ArmContact, WhatOverlapsAtTheStartIsExempt) {
  auto scene = empty_scene();
  add_table(scene);
  add_hand(scene, {0, 0, 1});
  ArmWorld arm(std::move(scene), {floating_arm(3, 1, capsule(0.05, 0.2), {0, 0, 0.14})});
  arm.world->step();
  EXPECT_TRUE(arm.world->arm_forces(0).empty());
}

TEST(ArmContact, ArmsPushEachOtherApart) {
  auto scene = empty_scene();
  add_hand(scene, {0, 0, 1});
  add_hand(scene, {3, 0, 1});
  ArmWorld arms(std::move(scene), {floating_arm(3, 1, capsule(0.05, 0.2), {0, 0, 0}),
                                   floating_arm(3, 1, capsule(0.05, 0.2), {0.11, 0, 0})});
  arms.move(1, 1, {-0.012, 0, 0}, 100);
  arms.world->step();
  EXPECT_NEAR(sum(arms.world->arm_forces(0)).x(), -200, 4);
  EXPECT_LT((sum(arms.world->arm_forces(0)) + sum(arms.world->arm_forces(1))).norm(), 1e-9);
  EXPECT_EQ(arms.world->arm_forces(0)[0].with, "hand1");
}

TEST(ArmContact, LinksOfOneArmTouchOnlyWhenFarApartInTheChain) {
  for (const int other : {3, 4}) {
    auto scene = empty_scene();
    add_hand(scene, {0, 0, 1});
    auto arm = floating_arm(6, 1, capsule(0.05, 0.2), {0, 0, 0});
    arm.model.links[static_cast<std::size_t>(other)].collision.push_back(capsule(0.05, 0.2));
    arm.X_WL[static_cast<std::size_t>(other)].translation() = {0.2, 0, 0};
    ArmWorld world(std::move(scene), {arm});
    world.move(0, other, {-0.101, 0, 0}, 100);
    EXPECT_EQ(world.world->arm_forces(0).empty(), other - 1 < 3) << other;
  }
}

class PushedPart : public testing::TestWithParam<robot::LinkShape> {};

// A link sweeps a tray and a gear off their places; the arm feels their friction.
TEST_P(PushedPart, YieldsToALinkAndLoadsIt) {
  auto scene = empty_scene();
  add_table(scene);
  add_tray(scene, "tray", "small4", {0, 0}, {"s1=g1"});
  add_hand(scene, {0, 0, 1});
  ArmWorld arm(std::move(scene), {floating_arm(3, 1, GetParam(), {-0.2, 0, 0.06})});
  for (int i = 0; i < 200; ++i) arm.world->step();
  EXPECT_GT(arm.world->virtual_joint_count(), 0);
  arm.move(0, 1, {0.25, 0, 0}, 1000);
  EXPECT_GT(arm.world->body(0).p_WB.x(), 0.1);
  // Sliding friction of tray and gear on the table.
  const double weight = (0.2 + 0.0102) * 9.81;
  EXPECT_NEAR(sum(arm.world->arm_forces(0)).x(), -0.4 * weight, 0.25 * weight);
  EXPECT_EQ(arm.world->arm_forces(0)[0].link, 1);
}

robot::LinkShape shape_of(
    std::variant<robot::BoxShape, robot::CapsuleShape, robot::CylinderShape, robot::SphereShape>
        kind) {
  robot::LinkShape shape;
  shape.shape = kind;
  return shape;
}

INSTANTIATE_TEST_SUITE_P(Shapes, PushedPart,
                         testing::Values(shape_of(robot::BoxShape{{0.1, 0.3, 0.1}}),
                                         shape_of(robot::CapsuleShape{0.055, 0.05}),
                                         shape_of(robot::CylinderShape{0.055, 0.11}),
                                         shape_of(robot::SphereShape{0.058})));

// A gear squeezed between a link and a table gives way elastically instead of blowing up.
TEST(ArmContact, SqueezedGearIsNotCrushedByAnImmovableObject) {
  auto scene = empty_scene();
  add_table(scene);
  Pose flat;
  flat.p.z() = 0.012;
  add_gear(scene, "gear", "small", flat);
  add_hand(scene, {0, 0, 1});
  ArmWorld arm(std::move(scene), {floating_arm(3, 1, shape_of(robot::BoxShape{{0.2, 0.2, 0.1}}),
                                               {0, 0, 0.05 + 0.038 + 0.002})});
  for (int i = 0; i < 50; ++i) arm.world->step();
  arm.move(0, 1, {0, 0, -0.003}, 200);
  for (int i = 0; i < 100; ++i) arm.world->step();
  const double force = sum(arm.world->arm_forces(0)).z();
  EXPECT_GT(force, 20);
  EXPECT_LT(force, 400);
  EXPECT_NEAR(arm.world->body(0).p_WB.z(), 0.012, 1e-3);
}

}  // namespace
}  // namespace aprsim::physics::test
