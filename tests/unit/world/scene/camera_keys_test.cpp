// The key "cameras" of a scene.

#include <cmath>
#include <numbers>
#include <ostream>
#include <string>

#include <gtest/gtest.h>

#include "world/scene/readers/camera_reader.hpp"

namespace aprsim::scene {
namespace {

/// A scene with one robot, whose vision looks at a square metre from above.
Scene scene_of_a_robot() {
  Scene scene;
  Robot robot;
  robot.name = "robbie";
  robot.X_WB.p = {1, 2, 0.9};
  robot.vision.area_min = {-0.5, -0.5};
  robot.vision.area_max = {0.5, 0.5};
  robot.vision.camera_V = {0, 0, 2};
  robot.vision.rate_hz = 25;
  robot.vision.latency_s = 0.2;
  scene.robots.push_back(robot);
  return scene;
}

/// The error in place of cameras, empty = none.
std::string read(const std::string& text, Scene& scene) {
  const auto document = yaml::Document::from_text("cameras:\n" + text, "s").value();
  read_cameras(document.root().map({"cameras"})["cameras"], scene);
  return document.error() ? document.error()->message : "";
}

Eigen::Vector2d pixel_of(const Camera& camera, const Eigen::Vector3d& p_W) {
  const Eigen::Vector3d p = camera.X_PC.isometry().inverse() * p_W;
  return camera.lens.pixel(p.head<2>() / p.z());
}

TEST(CameraKeys, ACameraOverARobotSeesTheAreaOfItsVision) {
  Scene scene = scene_of_a_robot();
  ASSERT_EQ(read("  - {name: top, over: robbie}\n", scene), "");
  const Camera& camera = scene.cameras.at(0);
  EXPECT_EQ(camera.robot, 0);
  EXPECT_EQ(camera.rate_hz, 25);
  EXPECT_EQ(camera.latency_s, 0.2);
  EXPECT_LT((camera.X_PC.p - Eigen::Vector3d(1, 2, 2.9)).norm(), 1e-12);
  // The area's far side is up: +x of the vision frame.
  EXPECT_LT((pixel_of(camera, {1, 2, 0.9}) - camera.lens.centre_px).norm(), 1e-9);
  EXPECT_LT(pixel_of(camera, {1.4, 2, 0.9}).y(), camera.lens.centre_px.y());
  EXPECT_LT(pixel_of(camera, {1, 2.4, 0.9}).x(), camera.lens.centre_px.x());
  for (const double x : {0.5, 1.5}) {
    for (const double y : {1.5, 2.5}) {
      const Eigen::Vector2d at = pixel_of(camera, {x, y, 0.9});
      EXPECT_TRUE(at.y() > 0 && at.y() < 719) << at.y();
    }
  }
}

TEST(CameraKeys, APlaceAndALensCanBeGiven) {
  Scene scene;
  ASSERT_EQ(read("  - name: lab\n    xyz_m: [0, 0, 1.5]\n    rpy_deg: [180, 0, 0]\n"
                 "    resolution_px: [1920, 1080]\n    focal_px: [2634, 2630]\n"
                 "    centre_px: [960, 541]\n    distortion: [-0.177, 0.02]\n    rate_hz: 5\n"
                 "    latency_s: 0.1\n    jpeg_quality: 70\n    exposure: 1.5\n    noise: 2\n"
                 "    blur_px: 1\n",
                 scene),
            "");
  const Camera& camera = scene.cameras.at(0);
  EXPECT_EQ(camera.robot, -1);
  EXPECT_LT((camera.X_PC.q * Eigen::Vector3d::UnitZ() + Eigen::Vector3d::UnitZ()).norm(), 1e-12);
  EXPECT_EQ(camera.lens.focal_px, Eigen::Vector2d(2634, 2630));
  EXPECT_EQ(camera.lens.centre_px, Eigen::Vector2d(960, 541));
  EXPECT_EQ(camera.lens.distortion, (std::array<double, 5>{-0.177, 0.02, 0, 0, 0}));
  EXPECT_EQ(camera.rate_hz, 5);
  EXPECT_EQ(camera.latency_s, 0.1);
  EXPECT_EQ(camera.jpeg_quality, 70);
  EXPECT_EQ(camera.exposure, 1.5);
  EXPECT_EQ(camera.noise, 2);
  EXPECT_EQ(camera.blur_px, 1);
}

TEST(CameraKeys, APointToLookAtIsInTheMiddle) {
  Scene scene;
  ASSERT_EQ(
      read("  - {name: side, xyz_m: [2, -2, 2], look_at_m: [0, 0.1, 0.9], focal_px: 800}\n", scene),
      "");
  const Camera& camera = scene.cameras.at(0);
  EXPECT_LT((pixel_of(camera, {0, 0.1, 0.9}) - camera.lens.centre_px).norm(), 1e-9);
}

TEST(CameraKeys, ACameraOnAFlangeHasItsPoseThere) {
  Scene scene = scene_of_a_robot();
  ASSERT_EQ(read("  - {name: tool, on_flange: robbie, xyz_m: [0.1, 0, 0.02], rpy_deg: [0, 90, 0],\n"
                 "     focal_px: 500}\n  - {name: top, over: robbie}\n",
                 scene),
            "");
  const Camera& camera = scene.cameras.at(0);
  EXPECT_FALSE(camera.is_fixed());
  EXPECT_EQ(camera.carrier, 0);
  EXPECT_EQ(camera.robot, -1);
  EXPECT_EQ(camera.X_PC.p, Eigen::Vector3d(0.1, 0, 0.02));
  EXPECT_LT((camera.X_PC.q * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitX()).norm(), 1e-12);
  EXPECT_TRUE(scene.cameras.at(1).is_fixed());
}

TEST(CameraKeys, DirtAndFlickerHaveDefaults) {
  Scene scene = scene_of_a_robot();
  ASSERT_EQ(read("  - {name: a, over: robbie, dirt: {share: 0.4}, flicker: {share: 0.2}}\n"
                 "  - {name: b, over: robbie, dirt: {share: 1, spots: 3, size: 0.1},\n"
                 "     flicker: {share: 0.5, rate_hz: 50}}\n  - {name: c, over: robbie}\n",
                 scene),
            "");
  EXPECT_EQ(scene.cameras[0].dirt.at(0), (LensDirt{.share = 0.4, .spots = 12, .size = 0.04}));
  EXPECT_EQ(scene.cameras[0].flicker.at(0), (Flicker{.share = 0.2, .rate_hz = 1.7}));
  EXPECT_EQ(scene.cameras[1].dirt.at(0), (LensDirt{.share = 1, .spots = 3, .size = 0.1}));
  EXPECT_EQ(scene.cameras[1].flicker.at(0), (Flicker{.share = 0.5, .rate_hz = 50}));
  EXPECT_TRUE(scene.cameras[2].dirt.empty());
  EXPECT_TRUE(scene.cameras[2].flicker.empty());
}

struct Mistake {
  const char* name;
  const char* text;
  const char* error;
};
std::ostream& operator<<(std::ostream& out, const Mistake& mistake) { return out << mistake.name; }

class CameraMistakes : public testing::TestWithParam<Mistake> {};

TEST_P(CameraMistakes, AreNamedWithTheirPlace) {
  Scene scene = scene_of_a_robot();
  const std::string error = read(GetParam().text, scene);
  EXPECT_NE(error.find(GetParam().error), std::string::npos) << error;
}

INSTANTIATE_TEST_SUITE_P(
    Keys, CameraMistakes,
    testing::Values(
        Mistake{"robot", "  - {name: a, over: robie}\n",
                "cameras[0].over: found no robot \"robie\", expected one of robbie"},
        Mistake{"twice", "  - {name: a, over: robbie}\n  - {name: a, over: robbie}\n",
                "cameras[1].name: found a second camera a, expected unique names"},
        Mistake{"place", "  - {name: a, focal_px: 500}\n",
                "cameras[0]: found a camera without a place, expected the key over or xyz_m"},
        Mistake{"direction", "  - {name: a, xyz_m: [0, 0, 2], focal_px: 500}\n",
                "found a camera without a direction, expected the key rpy_deg or look_at_m"},
        Mistake{"both",
                "  - {name: a, xyz_m: [0, 0, 2], rpy_deg: [0, 0, 0], look_at_m: [0, 0, 0]}\n",
                "cameras[0].look_at_m: found"},
        Mistake{"itself", "  - {name: a, xyz_m: [0, 0, 2], look_at_m: [0, 0, 2], focal_px: 9}\n",
                "expected a place away from the camera"},
        Mistake{"focal", "  - {name: a, xyz_m: [0, 0, 2], look_at_m: [0, 0, 0]}\n",
                "cameras[0]: found a camera without focal_px"},
        Mistake{"resolution", "  - {name: a, over: robbie, resolution_px: [640]}\n",
                "cameras[0].resolution_px: found a list, expected width and height"},
        Mistake{"size", "  - {name: a, over: robbie, resolution_px: [640, 5000]}\n",
                "cameras[0].resolution_px[1]: found 5000"},
        Mistake{"fold", "  - {name: a, over: robbie, focal_px: 600, distortion: [-0.4]}\n",
                "cameras[0].distortion: found a lens that folds the picture within its frame"},
        Mistake{"rate", "  - {name: a, over: robbie, rate_hz: 0}\n",
                "cameras[0].rate_hz: found 0, expected a number in (0, 60]"},
        Mistake{"quality", "  - {name: a, over: robbie, jpeg_quality: 101}\n",
                "cameras[0].jpeg_quality: found 101"},
        Mistake{"flange", "  - {name: a, on_flange: robbie, xyz_m: [0, 0, 0], focal_px: 500}\n",
                "found a camera on a flange without a pose, expected the keys xyz_m and rpy_deg"},
        Mistake{"carrier",
                "  - {name: a, on_flange: robie, xyz_m: [0, 0, 0], rpy_deg: [0, 0, 0]}\n",
                "cameras[0].on_flange: found no robot \"robie\""},
        Mistake{"both_robots", "  - {name: a, on_flange: robbie, over: robbie}\n",
                "cameras[0].over: found"},
        Mistake{"dirt", "  - {name: a, over: robbie, dirt: {spots: 3}}\n", "cameras[0].dirt"},
        Mistake{"spots", "  - {name: a, over: robbie, dirt: {share: 0.5, spots: 101}}\n",
                "cameras[0].dirt.spots: found 101"},
        Mistake{"flicker", "  - {name: a, over: robbie, flicker: {share: 1.5}}\n",
                "cameras[0].flicker.share: found 1.5"},
        Mistake{"key", "  - {name: a, over: robbie, fov_deg: 60}\n",
                "cameras[0].fov_deg: found an unknown key"}),
    [](const auto& test) { return test.param.name; });

TEST(CameraKeys, EightAreTheMost) {
  std::string text;
  for (int i = 0; i < 9; ++i) {
    text += "  - {name: c" + std::to_string(i) + ", over: robbie}\n";
  }
  Scene scene = scene_of_a_robot();
  EXPECT_NE(read(text, scene).find("expected at most 8 cameras"), std::string::npos);
}

}  // namespace
}  // namespace aprsim::scene
