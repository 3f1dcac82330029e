#include <cmath>
#include <numbers>
#include <sstream>

#include <gtest/gtest.h>

#include "tests/unit/world/scene/scene_fixture.hpp"
#include "world/scene/model/pieces.hpp"

// Parts, fixtures and materials of scene files.
namespace aprsim::scene {
namespace {

using Eigen::Vector3d;

class PartKeys : public SceneFiles {
 protected:
  [[nodiscard]] Result<Scene> load(const std::string& text) const {
    return SceneFiles::load(write("parts.yaml", text));
  }
  /// A scene with one part type, whose text follows "part_types:\n  thing:\n".
  [[nodiscard]] Result<Scene> load_type(const std::string& type) const {
    return load("part_types:\n  thing:\n" + type +
                "parts:\n  - {name: one, type: thing, xyz_m: [0, 0, 1]}\n");
  }
  void expect_error(const Result<Scene>& scene, const std::string& words) const {
    ASSERT_FALSE(scene);
    EXPECT_NE(scene.error().message.find(words), std::string::npos) << scene.error().message;
  }
};

TEST_F(PartKeys, EveryKindOfPieceIsReadWithItsMass) {
  const double pi = std::numbers::pi;
  struct MassCase {
    const char* shape;
    double volume_m3;
    Vector3d unit_inertia;  // of 1 kg/m^3, about the centre
  };
  const double a = 0.02, b = 0.03, c = 0.05, r = 0.01, h = 0.04;
  const double ball = 4 * pi / 3 * r * r * r, rod = pi * r * r * h;
  const double across_ball = ball * (0.4 * r * r + h * h / 4 + 3 * r * h / 8);
  const double across_rod = rod * (r * r / 4 + h * h / 12);
  const MassCase cases[] = {
      {"box: {size_m: [0.02, 0.03, 0.05]}", a * b * c,
       a * b * c / 12 * Vector3d(b * b + c * c, a * a + c * c, a * a + b * b)},
      {"cylinder: {radius_m: 0.01, height_m: 0.04}",
       rod,
       {across_rod, across_rod, rod * r * r / 2}},
      {"cone: {bottom_radius_m: 0.01, top_radius_m: 0, height_m: 0.04}", rod / 3,
       rod / 3 *
           Vector3d(3.0 / 80 * (4 * r * r + h * h), 3.0 / 80 * (4 * r * r + h * h), 0.3 * r * r)},
      {"sphere: {radius_m: 0.01}", ball, ball * 0.4 * r * r * Vector3d::Ones()},
      {"capsule: {radius_m: 0.01, length_m: 0.04}",
       rod + ball,
       {across_rod + across_ball, across_rod + across_ball, rod * r * r / 2 + ball * 0.4 * r * r}},
      {"prism: {corners_m: [[-0.01, -0.015], [0.01, -0.015], [0.01, 0.015], [-0.01, 0.015]], "
       "height_m: 0.05}",
       a * b * c, a * b * c / 12 * Vector3d(b * b + c * c, a * a + c * c, a * a + b * b)},
      {"hull: {points_m: [[-0.01, -0.015, -0.025], [0.01, -0.015, -0.025], [0.01, 0.015, -0.025], "
       "[-0.01, 0.015, -0.025], [-0.01, -0.015, 0.025], [0.01, -0.015, 0.025], [0.01, 0.015, "
       "0.025], "
       "[-0.01, 0.015, 0.025], [0, 0, 0]]}",
       a * b * c, a * b * c / 12 * Vector3d(b * b + c * c, a * a + c * c, a * a + b * b)}};
  for (const MassCase& tested : cases) {
    // Turned and moved: the inertia turns with it.
    const auto scene =
        load_type("    density_kg_m3: 2000\n    pieces:\n      - " + std::string(tested.shape) +
                  "\n        pose: {xyz_m: [0.1, 0.2, 0.3], rpy_deg: [0, 90, 0]}\n");
    ASSERT_TRUE(scene) << scene.error().message;
    const PartType& type = scene->part_types.at("thing");
    EXPECT_NEAR(type.mass_kg, 2000 * tested.volume_m3, 1e-12) << tested.shape;
    if (std::string(tested.shape).starts_with("cone")) {
      EXPECT_LT((type.com - Vector3d(0.1 - 0.01, 0.2, 0.3)).norm(), 1e-12);
    } else {
      EXPECT_LT((type.com - Vector3d(0.1, 0.2, 0.3)).norm(), 1e-12) << tested.shape;
    }
    const Vector3d& own = tested.unit_inertia;
    const Vector3d turned(own.z(), own.y(), own.x());
    EXPECT_LT((type.inertia.diagonal() - 2000 * turned).norm(), 1e-9 * 2000 * own.norm())
        << tested.shape << type.inertia;
  }
}

TEST_F(PartKeys, TheExampleOfTheDocumentsLoads) {
  const std::string text = read_file(APRSIM_SOURCE_DIR "/docs/scenes.md");
  const auto begin = text.find("```yaml\n");
  ASSERT_NE(begin, std::string::npos);
  const auto end = text.find("```", begin + 8);
  copy_shipped_scenes();
  const auto scene = load(text.substr(begin + 8, end - begin - 8));
  ASSERT_TRUE(scene) << scene.error().message;
  ASSERT_EQ(scene->parts.size(), 1u);
  EXPECT_NEAR(scene->parts[0].X_WP.p.z(), 0.1 + 0.03, 1e-12);
  EXPECT_EQ(scene->fixtures.at(0).pieces.size(), 1u);
  EXPECT_EQ(scene->part_types.at("battery").material, "plastic");
  EXPECT_EQ(scene->physics.materials.at(0).friction, 0.35);
}

TEST_F(PartKeys, MistakesNameFieldAndValue) {
  const std::string box = "    mass_kg: 1\n    pieces:\n      - box: {size_m: [0.1, 0.1, 0.1]}\n";
  expect_error(load_type("    mass_kg: 1\n    pieces: []\n"),
               "part_types.thing.pieces: found 0 pieces, expected 1 to 32 pieces");
  expect_error(load_type("    mass_kg: 1\n    pieces:\n      - {}\n"),
               "part_types.thing.pieces[0]: found 0 shapes, expected one of box");
  expect_error(load_type("    mass_kg: 1\n    pieces:\n      - {box: {size_m: [1, 1, 1]}, sphere: "
                         "{radius_m: 1}}\n"),
               "found 2 shapes");
  expect_error(load_type("    mass_kg: 1\n    pieces:\n      - {sphere: {radius_m: -1}}\n"),
               "part_types.thing.pieces[0].sphere.radius_m");
  expect_error(load_type("    mass_kg: 1\n    pieces:\n      - {cone: {bottom_radius_m: 0, "
                         "top_radius_m: 0, height_m: 1}}\n"),
               "found a cone with two radii of 0");
  expect_error(load_type("    mass_kg: 1\n    pieces:\n      - {hull: {points_m: [[0, 0, 0], [1, "
                         "0, 0], [0, 1, 0], [1, 1, 0]]}}\n"),
               "found points of one plane, expected points around a volume");
  expect_error(
      load_type(
          "    mass_kg: 1\n    pieces:\n      - {hull: {points_m: [[0, 0, 0], [1, 0, 0]]}}\n"),
      "found 2 points, expected 4 to 64 points");
  expect_error(load_type("    mass_kg: 1\n    pieces:\n      - {prism: {corners_m: [[0, 0], [0, "
                         "1], [1, 0]], height_m: 1}}\n"),
               "found corners in clockwise order");
  expect_error(
      load_type("    mass_kg: 1\n    density_kg_m3: 1\n    pieces: [{sphere: {radius_m: 1}}]\n"),
      "found mass_kg beside density_kg_m3");
  expect_error(
      load_type(
          "    mass_kg: 1\n    pieces: [{sphere: {radius_m: 0.1}}, {sphere: {radius_m: 0.1}}]\n"),
      "found pieces 0 and 1 that overlap by 200.0 mm");
  expect_error(load_type(box + "    com_m: [1, 0, 0]\n"), "part_types.thing.com_m");
  expect_error(load_type(box + "    inertia_kg_m2: [1, 1, 3]\n"), "part_types.thing.inertia_kg_m2");
  expect_error(load_type(box + "    colour: red\n"), "part_types.thing.colour");
  expect_error(load("physics:\n  materials:\n    - {between: [ice, fixed], friction: 0.1}\n"),
               "found no material \"ice\", expected one of belt, fixed, gear, robot, tray");
  expect_error(load("physics:\n  materials:\n    - {between: [gear], friction: 0.1}\n"),
               "physics.materials[0].between: found 1 materials, expected two materials");
  expect_error(load("physics:\n  materials:\n    - {between: [gear, tray], friction: 0.1}\n    - "
                    "{between: [tray, gear], friction: 0.1}\n"),
               "found a second pair of gear and tray");
  expect_error(load("parts:\n  - {name: one, type: nut, xyz_m: [0, 0, 1]}\n"),
               "found no part type \"nut\"");
}

TEST_F(PartKeys, OverlapsAreRefused) {
  const std::string type =
      "part_types:\n  peg:\n    mass_kg: 1\n    pieces: [{cylinder: {radius_m: 0.01, height_m: "
      "0.05}}]\n"
      "  ball:\n    mass_kg: 1\n    pieces: [{sphere: {radius_m: 0.02}}]\n"
      "fixtures:\n  - {name: post, xyz_m: [0, 0, 0.1], pieces: [{cylinder: {radius_m: 0.05, "
      "height_m: 0.2}}]}\n";
  const auto at = [&](const char* place) {
    return load(type + "parts:\n  - {name: one, type: ball, xyz_m: " + place + "}\n");
  };
  EXPECT_TRUE(at("[0.0701, 0, 0.1]"));
  expect_error(at("[0.06, 0, 0.1]"), "found one 10.0 mm deep in post");
  expect_error(at("[0.3, 0, 0.01]"), "found one 10.0 mm deep in the floor");
  // In a pocket it may be, in the slab beside it not.
  const std::string tray =
      type +
      "pockets: {hole: {top_radius_m: 0.0101, floor_radius_m: 0.0101, depth_m: 0.02}}\n"
      "tray_types:\n  plate: {kind: kit_tray, min_xy_m: [-0.1, -0.1], max_xy_m: [0.1, 0.1], "
      "thickness_m: 0.03, "
      "mass_kg: 1, slots: [{name: s, gear: peg, pocket: hole, xy_m: [0.05, 0]}]}\n"
      "trays: [{name: plate, type: plate, on: floor, xy_m: [0.3, 0]}]\n";
  const auto in_tray = [&](const char* place) {
    return load(tray + "parts:\n  - {name: one, type: peg, xyz_m: " + place + "}\n");
  };
  const auto seated = in_tray("[0.35, 0, 0.035]");
  EXPECT_TRUE(seated) << seated.error().message;
  expect_error(in_tray("[0.33, 0, 0.035]"), "deep in plate");
  expect_error(in_tray("[0.35, 0, 0.03]"), "deep in plate");
}

TEST_F(PartKeys, ASlotSeatsAPart) {
  const auto scene = load(
      "part_types:\n  peg:\n    mass_kg: 1\n    pieces: [{cylinder: {radius_m: 0.01, height_m: "
      "0.04}}]\n"
      "pockets: {hole: {top_radius_m: 0.0101, floor_radius_m: 0.0101, depth_m: 0.02}}\n"
      "tray_types:\n  plate: {kind: kit_tray, min_xy_m: [-0.1, -0.1], max_xy_m: [0.1, 0.1], "
      "thickness_m: 0.03, "
      "mass_kg: 1, slots: [{name: s, gear: peg, pocket: hole, xy_m: [0.05, 0]}]}\n"
      "trays: [{name: plate, type: plate, on: floor, xy_m: [0.3, 0], gears: {s: one}}]\n");
  ASSERT_TRUE(scene) << scene.error().message;
  ASSERT_EQ(scene->parts.size(), 1u);
  EXPECT_LT((scene->parts[0].X_WP.p - Vector3d(0.35, 0, 0.03)).norm(), 1e-12);
}

}  // namespace
}  // namespace aprsim::scene
