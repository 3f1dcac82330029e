// The key "vision" of a robot in a scene.

#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "world/scene/readers/vision_reader.hpp"

namespace aprsim::scene {
namespace {

TEST(VisionKeys, AbsentOnesKeepTheirDefaults) {
  auto document = yaml::Document::from_text("{rate_hz: 30}", "test").value();
  const Vision vision = read_vision(document.root());
  EXPECT_FALSE(document.error());
  EXPECT_EQ(vision.rate_hz, 30);
  EXPECT_EQ(vision.latency_s, Vision{}.latency_s);
  EXPECT_EQ(vision.X_RV.p, Eigen::Vector3d::Zero());
}

TEST(VisionKeys, AllAreTaken) {
  auto document =
      yaml::Document::from_text(
          "{frame: {xyz_m: [1, 2, 3], rpy_deg: [0, 0, 90]}, area: {min_m: [0, 0], max_m: [1, 2]},"
          " camera_m: [0.1, 0.2, 3], rate_hz: 5, latency_s: 0.2, position_noise_m: 0.002,"
          " rotation_noise_deg: 1, drop_rate: 0.1, shuffle: true, occlusion: false,"
          " gear_yaw_deg: 50, tray_yaw_offset_deg: -90, part_tray_flip_rate: 0.2, "
          " kit_tray_flip_rate: 0.4}",
          "test")
          .value();
  const Vision vision = read_vision(document.root());
  ASSERT_FALSE(document.error()) << document.error()->message;
  EXPECT_EQ(vision.X_RV.p, Eigen::Vector3d(1, 2, 3));
  EXPECT_NEAR((vision.X_RV.q * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(), 0,
              1e-12);
  EXPECT_EQ(vision.area_max, Eigen::Vector2d(1, 2));
  EXPECT_EQ(vision.camera_V, Eigen::Vector3d(0.1, 0.2, 3));
  EXPECT_EQ(vision.latency_s, 0.2);
  EXPECT_EQ(vision.position_noise_m, 0.002);
  EXPECT_NEAR(vision.rotation_noise_rad, std::numbers::pi / 180, 1e-15);
  EXPECT_EQ(vision.drop_rate, 0.1);
  EXPECT_TRUE(vision.shuffle);
  EXPECT_FALSE(vision.occlusion);
  ASSERT_TRUE(vision.gear_yaw_rad);
  EXPECT_NEAR(*vision.gear_yaw_rad, 50 * std::numbers::pi / 180, 1e-15);
  EXPECT_NEAR(vision.tray_yaw_offset_rad, -std::numbers::pi / 2, 1e-15);
  EXPECT_EQ(vision.part_tray_flip_rate, 0.2);
  EXPECT_EQ(vision.kit_tray_flip_rate, 0.4);
}

TEST(VisionKeys, TheCameraHangsBeforeTheRobotUnlessToldOtherwise) {
  auto document =
      yaml::Document::from_text("{area: {min_m: [0, -1], max_m: [1, 0]}}", "test").value();
  EXPECT_EQ(read_vision(document.root()).camera_V, Eigen::Vector3d(1, -0.5, 2));
  auto nothing = yaml::Document::from_text("{}", "test").value();
  const yaml::Node absent = nothing.root().map({"vision"})["vision"];
  EXPECT_EQ(read_vision(absent).camera_V, Eigen::Vector3d(1.2, 0, 2));
}

TEST(VisionKeys, FourPlacesMakeAnExactCalibration) {
  const double at[4][2] = {{0.36, -0.2}, {0.66, 0.16}, {0.33, 0.15}, {0.6, -0.15}};
  const double reported[4][2] = {{0.34, -0.2}, {0.64, 0.15}, {0.31, 0.16}, {0.58, -0.16}};
  std::string text = "{calibration: [";
  for (int i = 0; i < 4; ++i) {
    text += "{at_m: [" + std::to_string(at[i][0]) + ", " + std::to_string(at[i][1]) +
            "], reported_m: [" + std::to_string(reported[i][0]) + ", " +
            std::to_string(reported[i][1]) + "]},";
  }
  auto document = yaml::Document::from_text(text + "]}", "test").value();
  const Vision vision = read_vision(document.root());
  ASSERT_FALSE(document.error()) << document.error()->message;
  for (int i = 0; i < 4; ++i) {
    const double x = at[i][0], y = at[i][1];
    const Eigen::Vector2d image = vision.image * Eigen::Vector4d(1, x, y, x * y);
    EXPECT_LT((image - Eigen::Vector2d(reported[i][0], reported[i][1])).norm(), 1e-12);
    const double step = 1e-6;
    const Eigen::Vector2d beside = vision.image * Eigen::Vector4d(1, x, y + step, x * (y + step));
    EXPECT_LT(((beside - image) / step - vision.image_slope({x, y}).col(1)).norm(), 1e-8);
  }
}

TEST(VisionKeys, BadValuesAreErrorsThatNameTheKey) {
  const std::pair<const char*, const char*> cases[] = {
      {"{rate_hz: 0}", "rate_hz"},
      {"{rate_hz: 101}", "rate_hz"},
      {"{latency_s: -0.1}", "latency_s"},
      {"{latency_s: 6}", "latency_s"},
      {"{position_noise_m: 0.2}", "position_noise_m"},
      {"{rotation_noise_deg: -1}", "rotation_noise_deg"},
      {"{drop_rate: 1.5}", "drop_rate"},
      {"{shuffle: perhaps}", "shuffle"},
      {"{occlusion: 1}", "occlusion"},
      {"{camera_m: [1, 2]}", "camera_m"},
      {"{frame: {xyz_m: [1, 2]}}", "frame.xyz_m"},
      {"{area: {min_m: [0, 0]}}", "area.max_m"},
      {"{area: {min_m: [0, 0], max_m: [1, 0]}}", "area.max_m"},
      {"{rate: 5}", "rate"},
      {"{gear_yaw_deg: 181}", "gear_yaw_deg"},
      {"{tray_yaw_offset_deg: 200}", "tray_yaw_offset_deg"},
      {"{part_tray_flip_rate: 2}", "part_tray_flip_rate"},
      {"{kit_tray_flip_rate: -1}", "kit_tray_flip_rate"},
      {"{calibration: 3}", "calibration"},
      {"{calibration: [{at_m: [0, 0], reported_m: [0, 0]}]}", "calibration"},
      // On one line; mirrored; a place without its image.
      {"{calibration: [{at_m: [0, 0], reported_m: [0, 0]}, {at_m: [1, 0], reported_m: [1, 0]},"
       " {at_m: [2, 0], reported_m: [2, 0]}, {at_m: [3, 0], reported_m: [3, 0]}]}",
       "calibration"},
      {"{calibration: [{at_m: [0, 0], reported_m: [0, 0]}, {at_m: [1, 0], reported_m: [-1, 0]},"
       " {at_m: [0, 1], reported_m: [0, 1]}, {at_m: [1, 1], reported_m: [-1, 1]}]}",
       "calibration"},
      {"{calibration: [{at_m: [0, 0]}, {at_m: [1, 0]}, {at_m: [0, 1]}, {at_m: [1, 1]}]}",
       "calibration[0].reported_m"},
  };
  for (const auto& [text, key] : cases) {
    auto document = yaml::Document::from_text(text, "test").value();
    (void)read_vision(document.root());
    ASSERT_TRUE(document.error()) << text;
    EXPECT_NE(document.error()->field.find(key), std::string::npos) << document.error()->message;
  }
}

}  // namespace
}  // namespace aprsim::scene
