#include "world/scene/model/free_body.hpp"

#include <gtest/gtest.h>

namespace aprsim::scene {
namespace {

Scene tray_and_gear() {
  Scene scene;
  TrayType tray;
  tray.kind = api::BodyKind::kKitTray;
  tray.min_xy = {-0.1, -0.05};
  tray.max_xy = {0.1, 0.06};
  tray.thickness_m = 0.02;
  tray.mass_kg = 0.5;
  GearType gear;
  gear.disc_radius_m = 0.03;
  gear.disc_height_m = 0.01;
  gear.peg_radius_m = 0.005;
  gear.peg_top_m = 0.04;
  gear.mass_kg = 0.04;
  scene.tray_types["kit"] = tray;
  scene.gear_types["cog"] = gear;
  scene.gears.push_back({"cog_1", "cog", {}});
  scene.trays.push_back({.name = "kit_1", .type = "kit", .X_WP = {}});
  return scene;
}

TEST(FreeBody, ListsTraysThenGearsWithTheirOutlines) {
  const auto bodies = free_bodies_of(tray_and_gear());
  ASSERT_EQ(bodies.size(), 2U);
  const FreeBody &tray = bodies[0], &gear = bodies[1];
  EXPECT_EQ(tray.name, "kit_1");
  EXPECT_EQ(tray.type, "kit");
  EXPECT_EQ(tray.kind, api::BodyKind::kKitTray);
  EXPECT_EQ(tray.mass_kg, 0.5);
  EXPECT_EQ(tray.slab.min(), Eigen::Vector3d(-0.1, -0.05, -0.02));
  EXPECT_EQ(tray.slab.max(), Eigen::Vector3d(0.1, 0.06, 0));
  EXPECT_EQ(gear.name, "cog_1");
  EXPECT_TRUE(gear.is_gear());
  EXPECT_EQ(gear.mass_kg, 0.04);
  EXPECT_EQ(gear.disc_radius_m, 0.03);
  EXPECT_EQ(gear.disc_height_m, 0.01);
  EXPECT_EQ(gear.peg_radius_m, 0.005);
  EXPECT_EQ(gear.peg_top_m, 0.04);
}

TEST(FreeBody, AnOutlineCoversLessThanTheBoxAroundIt) {
  Scene scene = tray_and_gear();
  scene.tray_types["kit"].outline =
      outline_of({{-0.1, -0.05}, {0.1, -0.05}, {0.1, 0}, {0, 0.06}, {-0.1, 0.06}});
  const FreeBody tray = free_bodies_of(scene)[0];
  const auto stands = [&](double x_P, double y_P) {
    return stands_on(Eigen::Isometry3d(Eigen::Translation3d(x_P, y_P, 0)),
                     Eigen::Isometry3d::Identity(), tray);
  };
  EXPECT_TRUE(stands(0.05, 0.029));
  EXPECT_FALSE(stands(0.05, 0.031)) << "beside the slanted side";
  EXPECT_FALSE(stands(0.09, 0.05)) << "in the corner of the box";
  EXPECT_TRUE(stands(-0.09, 0.05));
}

TEST(FreeBody, AGearStandsOnTheTrayBelowIt) {
  const FreeBody tray = free_bodies_of(tray_and_gear())[0];
  const Eigen::Isometry3d X_WP =
      Eigen::Translation3d(1, 2, 0.9) * Eigen::AngleAxisd(0.5 * M_PI, Eigen::Vector3d::UnitZ());
  const auto stands = [&](double x_P, double y_P, double z_P) {
    return stands_on(X_WP * Eigen::Translation3d(x_P, y_P, z_P), X_WP, tray);
  };
  EXPECT_TRUE(stands(0, 0, 0));
  EXPECT_TRUE(stands(0.099, -0.049, -0.0049));
  EXPECT_TRUE(stands(-0.099, 0.059, 0.0049));
  EXPECT_FALSE(stands(0.101, 0, 0)) << "beside it";
  EXPECT_FALSE(stands(0, 0.061, 0)) << "beside it";
  EXPECT_FALSE(stands(0, 0, 0.0051)) << "in the air";
  EXPECT_FALSE(stands(0, 0, -0.0051)) << "below it";
}

}  // namespace
}  // namespace aprsim::scene
