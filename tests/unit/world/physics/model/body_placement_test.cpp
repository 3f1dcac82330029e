#include "world/physics/model/body_placement.hpp"

#include <gtest/gtest.h>

#include "tests/unit/world/physics/cell_builder.hpp"

namespace aprsim::physics::test {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// A tray on a table, and two gears in the air.
class Placing : public testing::Test {
 protected:
  static constexpr int kTray = 0, kGear = 1, kOther = 2;

  static scene::Scene make_scene() {
    auto scene = empty_scene();
    add_table(scene);
    add_tray(scene, "tray", "small4", {0, 0}, {});
    add_gear(scene, "gear", "small", {.p = {0.4, 0, 0.2}});
    add_gear(scene, "other", "small", {.p = {-0.4, 0, 0.2}});
    return scene;
  }
  void expect_clear(int body, const Aabb& other) {
    const Aabb& own = model_.body(body).bounds;
    EXPECT_TRUE(own.min.z() > other.max.z() || !own.meets(other));
  }

  scene::Scene scene_ = make_scene();
  PhysicsModel model_{scene_, {}, {}};
  BodyPlacement placement_{model_};
};

TEST_F(Placing, RaisesWhatWouldOverlapUntilItIsClear) {
  const BodyPose inside{kGear, Isometry3d(Eigen::Translation3d(0.02, 0.02, -0.01))};
  placement_.place({&inside, 1});
  expect_clear(kGear, model_.body(kTray).bounds);
  for (const StaticShape& shape : model_.fixed.shapes) expect_clear(kGear, shape.bounds);
  EXPECT_LT(model_.body(kGear).bounds.min.z() - model_.body(kTray).bounds.max.z(), 1e-3);
  EXPECT_TRUE(model_.body(kGear).v_com_W.isZero(0));
}

TEST_F(Placing, KeepsBodiesThatArePutTogetherAsTheyAre) {
  const std::array<BodyPose, 2> both{{{kGear, Isometry3d(Eigen::Translation3d(0, 0, 0))},
                                      {kOther, Isometry3d(Eigen::Translation3d(0.001, 0, 0.001))}}};
  placement_.place(both);
  const Vector3d apart =
      model_.body(kOther).X_WB.translation() - model_.body(kGear).X_WB.translation();
  EXPECT_LT((apart - Vector3d(0.001, 0, 0.001)).norm(), 1e-12);
}

TEST_F(Placing, RemovedBodyStaysLost) {
  placement_.remove(kGear, 7);
  EXPECT_EQ(model_.body(kGear).lost_step, 7u);
  EXPECT_LT(model_.body(kGear).bounds.max.z(), model_.lost_below_m);
  placement_.remove(kGear, 9);
  EXPECT_EQ(model_.body(kGear).lost_step, 7u);
  const Isometry3d before = model_.body(kGear).X_WB;
  const BodyPose back{kGear, Isometry3d::Identity()};
  placement_.place({&back, 1});
  EXPECT_EQ(model_.body(kGear).X_WB.matrix(), before.matrix());
}

TEST_F(Placing, LosesWhatHasFallen) {
  FreeBody& gear = model_.body(kGear);
  Isometry3d X_WB = gear.X_WB;
  X_WB.translation().z() = model_.lost_below_m - 0.1;
  gear.place(X_WB, {0, 0, -5}, Vector3d::Zero());
  placement_.lose_bodies(3);
  EXPECT_EQ(gear.lost_step, 3u);
  EXPECT_TRUE(gear.v_com_W.isZero(0));
  EXPECT_FALSE(model_.body(kOther).lost_step.has_value());
}

}  // namespace
}  // namespace aprsim::physics::test
