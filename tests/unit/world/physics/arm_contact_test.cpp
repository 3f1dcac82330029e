// Links against links, fixed things and loose parts: the penalty law acts where the solver computes
// no force, and free bodies yield.

#include <cmath>

#include <gtest/gtest.h>

#include "tests/unit/world/physics/cell_builder.hpp"
#include "world/robot/servo/contact_law.hpp"

namespace aprsim::physics::test {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kBallRadius = 0.05;

/// Arms that are one ball (or another shape) each; their grippers are far above.
class Balls {
 public:
  using Shape = decltype(robot::LinkShape::shape);

  explicit Balls(scene::Scene the_scene, const std::vector<Vector3d>& centres,
                 const Shape& shape = robot::SphereShape{kBallRadius})
      : scene(std::move(the_scene)) {
    std::vector<std::vector<Isometry3d>> X_WL;
    for (const Vector3d& centre : centres) {
      add_hand(scene, centre + Vector3d(0, 0, 2));
      robot::ArmModel model;
      model.name = scene.robots.back().name;
      model.joints.resize(2);
      model.links.resize(3);
      model.links[1].collision.push_back({Isometry3d::Identity(), shape});
      models.push_back(model);
      X_WL.push_back(poses(scene.robots.size() - 1, centre));
      at.push_back(centre);
    }
    world = std::make_unique<PhysicsWorld>(scene, models, X_WL);
  }

  void step(const std::vector<Vector3d>& velocities) {
    for (std::size_t r = 0; r < at.size(); ++r) {
      at[r] += 1e-3 * velocities[r];
      world->set_arm(static_cast<int>(r), poses(r, at[r]));
    }
    world->step();
  }

  [[nodiscard]] Vector3d sum(int robot) const {
    Vector3d f = Vector3d::Zero();
    for (const auto& force : world->arm_forces(robot)) f += force.f_W;
    return f;
  }

  [[nodiscard]] std::string partner_of(const ArmForce& force) const {
    return name_of(scene, *world, force.partner);
  }

  scene::Scene scene;
  std::vector<robot::ArmModel> models;
  std::vector<Vector3d> at;
  std::unique_ptr<PhysicsWorld> world;

 private:
  [[nodiscard]] std::vector<Isometry3d> poses(std::size_t robot, const Vector3d& centre) const {
    const Isometry3d base = scene.robots[robot].X_WB.isometry();
    Isometry3d ball = Isometry3d::Identity();
    ball.translation() = centre;
    return {base, ball, base};
  }
};

/// Two balls that have just come together along x, to this depth; what overlaps from the start is
/// exempt.
Balls pressed(double depth_m) {
  Balls balls(empty_scene(), {{0, 0, 0.5}, {2 * kBallRadius + 1e-4, 0, 0.5}});
  balls.step({Vector3d::Zero(), Vector3d::Zero()});
  EXPECT_TRUE(balls.world->arm_forces(0).empty());
  EXPECT_TRUE(balls.world->arm_forces(1).empty());
  balls.step({Vector3d::Zero(), Vector3d(-(depth_m + 1e-4) / 1e-3, 0, 0)});
  return balls;
}

TEST(ArmAgainstArm, ForcesAreEqualAndOppositeAndFollowThePenaltyLaw) {
  Balls balls = pressed(1e-3);
  balls.step({Vector3d::Zero(), Vector3d::Zero()});
  ASSERT_EQ(balls.world->arm_forces(0).size(), 1u);
  ASSERT_EQ(balls.world->arm_forces(1).size(), 1u);
  const ArmForce &on_a = balls.world->arm_forces(0)[0], &on_b = balls.world->arm_forces(1)[0];
  EXPECT_TRUE(on_a.f_W.isApprox(-on_b.f_W, 0));
  EXPECT_TRUE(on_a.p_W.isApprox(on_b.p_W, 0));
  EXPECT_EQ(on_a.link, 1);
  EXPECT_EQ(on_b.link, 1);
  EXPECT_EQ(balls.partner_of(on_a), balls.scene.robots[1].name);
  EXPECT_EQ(balls.partner_of(on_b), balls.scene.robots[0].name);
  EXPECT_NEAR(on_b.f_W.x(), 100, 1e-6);  // 1e5 N/m, 1 mm deep
  EXPECT_NEAR(on_b.f_W.tail<2>().norm(), 0, 1e-9);
  EXPECT_NEAR(on_a.p_W.x(), kBallRadius, 1e-3);
}

TEST(ArmAgainstArm, DepthAndClosingSpeedAddUpAndNothingPulls) {
  Balls closing = pressed(1.8e-3);
  closing.step({Vector3d::Zero(), Vector3d(-0.2, 0, 0)});
  EXPECT_GT(closing.sum(1).x(), 210);  // 2 mm deep and still closing
  Balls leaving = pressed(3.5e-3);
  leaving.step({Vector3d::Zero(), Vector3d(1.5, 0, 0)});
  EXPECT_GE(leaving.sum(1).x(), 0);  // 2 mm deep, leaving: less, but never a pull
  EXPECT_LT(leaving.sum(1).x(), 100);
  leaving.step({Vector3d::Zero(), Vector3d(3, 0, 0)});
  EXPECT_TRUE(leaving.world->arm_forces(1).empty());
}

TEST(ArmAgainstArm, SlidingMeetsCoulombFriction) {
  Balls balls = pressed(1e-3);
  balls.step({Vector3d::Zero(), Vector3d(0, 0.5, 0)});
  const Vector3d f = balls.sum(1);
  const Vector3d n = (balls.at[1] - balls.at[0]).normalized();
  const double normal = f.dot(n), along = (f - normal * n).norm();
  EXPECT_LT(f.y(), 0);  // against the slip
  EXPECT_NEAR(along, balls.scene.physics.friction.robot * normal, 1e-6 * normal);
  EXPECT_NEAR((balls.sum(0) + balls.sum(1)).norm(), 0, 1e-9);
}

TEST(ArmAgainstFixedThings, ATablePushesBackByItsName) {
  auto scene = empty_scene();
  add_table(scene);
  Balls balls(std::move(scene), {{0, 0, kBallRadius + 1e-3}});
  balls.step({Vector3d(0, 0, 0)});
  EXPECT_TRUE(balls.world->arm_forces(0).empty());
  for (int i = 0; i < 20; ++i) balls.step({Vector3d(0, 0, -0.1)});
  for (int i = 0; i < 5; ++i) balls.step({Vector3d::Zero()});
  ASSERT_EQ(balls.world->arm_forces(0).size(), 1u);
  EXPECT_EQ(balls.partner_of(balls.world->arm_forces(0)[0]), "table");
  EXPECT_NEAR(balls.sum(0).z(), 100, 1e-6);
}

// A gear pushed over the table by a link: it keeps ahead of the link, at the link's speed, and
// loads the arm with its friction on the table.
TEST(ArmAgainstLooseParts, APushedPartYieldsAndLoadsTheArm) {
  constexpr double kSide = 0.1, kMass = 0.5;
  auto scene = empty_scene();
  add_table(scene);
  scene.physics.simplification = scene::Simplification::kOff;
  auto& puck = scene.gear_types["puck"] = gear_type("d60");
  puck.mass_kg = kMass;
  Pose pose;
  pose.p = {0.2, 0, puck.hub_height_m};
  add_gear(scene, "puck", "puck", pose);
  const double reach = puck.disc_radius_m;
  Balls balls(std::move(scene), {{0.2 - reach - 0.5 * kSide - 2e-3, 0, 0.5 * kSide + 2e-3}},
              robot::BoxShape{Vector3d::Constant(kSide)});
  balls.step({Vector3d::Zero()});
  ASSERT_TRUE(balls.world->arm_forces(0).empty());
  Vector3d mean = Vector3d::Zero();
  for (int i = 0; i < 1000; ++i) {
    balls.step({Vector3d(0.1, 0, 0)});
    if (i >= 500) mean += balls.sum(0) / 500;
  }
  const BodyState state = balls.world->body(0);
  EXPECT_NEAR(state.p_WB.x() - balls.at[0].x(), reach + 0.5 * kSide, 0.3e-3);
  EXPECT_NEAR(state.v_W.x(), 0.1, 0.005);
  // The link's friction may press the part down or lift it, as far as Coulomb allows.
  const auto& mu = balls.scene.physics.friction;
  const double weight = kMass * 9.81, both = mu.gear_ground * mu.robot;
  EXPECT_GE(-mean.x(), mu.gear_ground * weight / (1 + both) * 0.99);
  EXPECT_LE(-mean.x(), mu.gear_ground * weight / (1 - both) * 1.01);
  ASSERT_FALSE(balls.world->arm_forces(0).empty());
  EXPECT_EQ(balls.partner_of(balls.world->arm_forces(0)[0]), "puck");
  EXPECT_EQ(balls.world->arm_forces(0)[0].link, 1);
}

// Held back by a wall, the part is squeezed: the arm feels more than friction, the part stays
// whole and where it is.
TEST(ArmAgainstLooseParts, ASqueezedPartLoadsTheArmWithoutFlyingOff) {
  constexpr double kSide = 0.1;
  auto scene = empty_scene();
  add_table(scene);
  scene.physics.simplification = scene::Simplification::kOff;
  const auto& gear = scene.gear_types.at("d60");
  Pose pose;
  pose.p = {0.2, 0, gear.hub_height_m};
  add_gear(scene, "puck", "d60", pose);
  const double reach = gear.disc_radius_m;
  Pose wall;
  wall.p = {0.2 + reach + 0.05, 0, 0.05};
  scene.fixed.push_back({"wall", Vector3d::Constant(0.1), wall});
  Balls balls(std::move(scene), {{0.2 - reach - 0.5 * kSide - 1e-3, 0, 0.5 * kSide + 2e-3}},
              robot::BoxShape{Vector3d::Constant(kSide)});
  for (int i = 0; i < 20; ++i) balls.step({Vector3d(0.1, 0, 0)});
  for (int i = 0; i < 200; ++i) balls.step({Vector3d::Zero()});
  EXPECT_LT(balls.sum(0).x(), -10);
  EXPECT_GT(balls.sum(0).x(), -500);
  EXPECT_NEAR(balls.world->body(0).p_WB.x(), 0.2, 1e-3);
  EXPECT_LT(balls.world->body(0).v_W.norm(), 1e-3);
}

}  // namespace
}  // namespace aprsim::physics::test
