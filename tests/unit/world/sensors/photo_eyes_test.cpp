#include "world/sensors/photo_eyes.hpp"

#include <gtest/gtest.h>

namespace aprsim::sensors {
namespace {

/// A belt turned by a quarter turn, its top at z = 0.9, with two eyes.
scene::Conveyor belt() {
  scene::Conveyor conveyor;
  conveyor.X_WC.p = {1, 2, 0.9};
  conveyor.X_WC.q = Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ());
  conveyor.length_m = 3;
  conveyor.width_m = 0.6;
  conveyor.photo_eyes = {{.name = "a", .x_m = 0.5, .height_m = 0.01},
                         {.name = "b", .x_m = -0.5, .height_m = 0.03}};
  return conveyor;
}

/// Pose of a body in the belt's frame, as a world pose.
Pose on_belt(double x, double y, double z, double yaw = 0) {
  Pose X_CB;
  X_CB.p = {x, y, z};
  X_CB.q = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ());
  return Pose::from(belt().X_WC.isometry() * X_CB.isometry());
}

scene::FreeBody tray_on_belt() {
  scene::FreeBody body;
  body.kind = api::BodyKind::kPartTray;
  body.mass_kg = 0.5;
  body.slab =
      Eigen::AlignedBox3d(Eigen::Vector3d(-0.06, -0.1, -0.017), Eigen::Vector3d(0.06, 0.1, 0));
  return body;
}

scene::FreeBody gear_on_belt() {
  scene::FreeBody body;
  body.kind = api::BodyKind::kGear;
  body.mass_kg = 0.03;
  body.disc_radius_m = 0.05;
  body.disc_height_m = 0.02;
  body.peg_radius_m = 0.004;
  body.peg_top_m = 0.035;
  return body;
}

TEST(PhotoEyes, ATrayBreaksTheBeamFromItsFrontEdgeToItsBack) {
  const PhotoEyes eyes(belt());
  EXPECT_FALSE(eyes.breaks(0, tray_on_belt(), on_belt(0.439, 0.1, 0.017)));
  EXPECT_TRUE(eyes.breaks(0, tray_on_belt(), on_belt(0.441, 0.1, 0.017)));
  EXPECT_TRUE(eyes.breaks(0, tray_on_belt(), on_belt(0.559, -0.1, 0.017)));
  EXPECT_FALSE(eyes.breaks(0, tray_on_belt(), on_belt(0.561, 0, 0.017)));
  EXPECT_TRUE(eyes.breaks(0, tray_on_belt(), on_belt(0.405, 0, 0.017, M_PI / 2))) << "across";
}

TEST(PhotoEyes, TheBeamHasAHeightAndEndsAtTheBeltsEdges) {
  const PhotoEyes eyes(belt());
  EXPECT_FALSE(eyes.breaks(1, tray_on_belt(), on_belt(-0.5, 0, 0.017))) << "passes over the tray";
  EXPECT_FALSE(eyes.breaks(0, tray_on_belt(), on_belt(0.5, 0, 0.1))) << "lifted out";
  EXPECT_TRUE(eyes.breaks(0, tray_on_belt(), on_belt(0.5, 0.399, 0.017)));
  EXPECT_FALSE(eyes.breaks(0, tray_on_belt(), on_belt(0.5, 0.401, 0.017))) << "beside the belt";
}

TEST(PhotoEyes, AGearBreaksItWithDiscAndPeg) {
  const PhotoEyes eyes(belt());
  EXPECT_TRUE(eyes.breaks(0, gear_on_belt(), on_belt(0.451, 0, 0)));
  EXPECT_FALSE(eyes.breaks(0, gear_on_belt(), on_belt(0.449, 0, 0)));
  EXPECT_TRUE(eyes.breaks(1, gear_on_belt(), on_belt(-0.503, 0, 0))) << "the peg, above the disc";
  EXPECT_FALSE(eyes.breaks(1, gear_on_belt(), on_belt(-0.505, 0, 0)));
  // Lying on its side, the disc's edge is up to 0.05 m from the axis.
  Pose lying = on_belt(0.5, 0, 0.05);
  lying.q = lying.q * Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX());
  EXPECT_TRUE(eyes.breaks(0, gear_on_belt(), lying));
}

TEST(PhotoEyes, APartBreaksItWithAnyOfItsPieces) {
  const PhotoEyes eyes(belt());
  scene::FreeBody part;
  part.kind = api::BodyKind::kPart;
  Pose high;
  high.p = {0.03, 0, 0.02};
  part.pieces = {{api::BoxPiece{{0.02, 0.02, 0.04}}, {}}, {api::CapsulePiece{0.01, 0}, high}};
  EXPECT_TRUE(eyes.breaks(0, part, on_belt(0.491, 0, 0.02)));
  EXPECT_FALSE(eyes.breaks(0, part, on_belt(0.489, 0, 0.02))) << "under the ball";
  EXPECT_TRUE(eyes.breaks(1, part, on_belt(-0.537, 0, 0.01))) << "the ball";
  EXPECT_FALSE(eyes.breaks(1, part, on_belt(-0.541, 0, 0.01)));
}

TEST(PhotoEyes, CountsEachTimeTheBeamIsBrokenAnew) {
  PhotoEyes eyes(belt());
  const auto look = [&](double x) {
    eyes.begin();
    eyes.see(tray_on_belt(), on_belt(x, 0, 0.017));
    eyes.finish();
  };
  look(0.5);
  EXPECT_TRUE(eyes.eyes()[0].broken);
  EXPECT_EQ(eyes.eyes()[0].count, 0U) << "it stood there from the start";
  for (int round = 1; round <= 3; ++round) {
    look(0.3);
    EXPECT_FALSE(eyes.eyes()[0].broken);
    look(0.45);
    look(0.5);
    EXPECT_TRUE(eyes.eyes()[0].broken);
    EXPECT_EQ(eyes.eyes()[0].count, static_cast<std::uint32_t>(round));
  }
  EXPECT_EQ(eyes.eyes()[1].count, 0U);
}

TEST(PhotoEyes, WeighsWhatTheBeltCarries) {
  PhotoEyes eyes(belt());
  eyes.begin();
  eyes.see(tray_on_belt(), on_belt(1.4, 0.2, 0.017));
  eyes.see(gear_on_belt(), on_belt(1.4, 0.2, 0.017));
  eyes.see(gear_on_belt(), on_belt(0, 0.31, 0.017));  // beside
  eyes.see(gear_on_belt(), on_belt(0, 0, 0.2));       // in a gripper
  eyes.see(gear_on_belt(), on_belt(0, 0, -0.9));      // on the floor
  eyes.finish();
  EXPECT_NEAR(eyes.load_kg(), 0.53, 1e-12);
}

}  // namespace
}  // namespace aprsim::sensors
