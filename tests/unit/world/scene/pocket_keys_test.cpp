#include <cmath>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "tests/unit/world/scene/scene_fixture.hpp"
#include "world/scene/readers/pocket_reader.hpp"

// Pockets with an outline in scene files.
namespace aprsim::scene {
namespace {

class PocketKeys : public SceneFiles {
 protected:
  /// A tray with two slots for a key of 8 x 7 x 50 mm; `second` has further keys of the second.
  [[nodiscard]] Result<Scene> load_pocket(const std::string& pocket,
                                          const std::string& second = "xy_m: [0.05, 0]",
                                          const std::string& rest = "") const {
    return load(write(
        "pockets.yaml",
        "pockets:\n  hole: " + pocket +
            "\n  round: {top_radius_m: 0.01, floor_radius_m: 0.01, depth_m: 0.02}\n"
            "part_types:\n  key: {density_kg_m3: 7850, pieces: [{box: {size_m: [0.008, 0.007, "
            "0.05]}}]}\n"
            "tray_types:\n  plate:\n    kind: kit_tray\n    min_xy_m: [-0.1, -0.1]\n"
            "    max_xy_m: [0.1, 0.1]\n    thickness_m: 0.03\n    mass_kg: 1\n    slots:\n"
            "      - {name: a, gear: key, pocket: hole, xy_m: [0, 0]}\n"
            "      - {name: b, gear: key, pocket: hole, " +
            second + "}\n" + rest));
  }
  void expect_error(const Result<Scene>& scene, const std::string& words) const {
    ASSERT_FALSE(scene) << words;
    EXPECT_NE(scene.error().message.find(words), std::string::npos) << scene.error().message;
  }
};

constexpr const char* kKeyHole = "{rectangle: {size_m: [0.0081, 0.0071]}, depth_m: 0.02}";

TEST_F(PocketKeys, ARectangleIsAnOutline) {
  const auto scene = load_pocket(kKeyHole);
  ASSERT_TRUE(scene) << scene.error().message;
  const Slot& slot = scene->tray_types.at("plate").slots[0];
  ASSERT_TRUE(slot.pocket.outline);
  EXPECT_EQ(slot.pocket.outline->corners.size(), 4u);
  EXPECT_EQ(slot.pocket.top_radius_m, 0);
  EXPECT_DOUBLE_EQ(slot.pocket.outline->depth_of({0.003, 0}), 0.00105);
  EXPECT_DOUBLE_EQ(slot.pocket.outline->depth_of({0, 0.003}), 0.00055);
  EXPECT_EQ(slot.yaw_rad, 0);
}

TEST_F(PocketKeys, ARoundPocketHasNoOutline) {
  const auto scene = load_pocket("{top_radius_m: 0.006, floor_radius_m: 0.006, depth_m: 0.02}");
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_FALSE(scene->tray_types.at("plate").slots[0].pocket.outline);
}

// The chords lie outside the arc, nowhere further than 0.9 % of the radius.
TEST_F(PocketKeys, RoundedCornersHoldTheArc) {
  const Eigen::Vector2d size(0.04, 0.02);
  for (const double r : {0.001, 0.004, 0.01}) {
    const Outline outline = rectangle_outline(size, r);
    EXPECT_EQ(outline.corners.size(), Outline::kMaxCorners);
    const Eigen::Vector2d centre = 0.5 * size - Eigen::Vector2d::Constant(r);
    for (int i = 0; i <= 90; ++i) {
      const double angle = i * std::numbers::pi / 180;
      const Eigen::Vector2d arc = centre + r * Eigen::Vector2d(std::cos(angle), std::sin(angle));
      const double depth = outline.depth_of(arc);
      EXPECT_GE(depth, -1e-12) << i;
      EXPECT_LT(depth, 0.009 * r) << i;
    }
    EXPECT_NEAR(outline.depth_of({0, 0}), 0.01, 1e-12);
  }
}

TEST_F(PocketKeys, TheSlotTurnsThePocketAndItsPart) {
  const std::string tray =
      "trays:\n  - {name: plate, type: plate, on: floor, xy_m: [0.3, 0], yaw_deg: 20, gears: {b: "
      "key_1}}\n";
  // The key's frame is in its middle.
  const std::string hole = "{rectangle: {size_m: [0.0081, 0.0071]}, depth_m: 0.025}";
  const auto scene = load_pocket(hole, "xy_m: [0.05, 0], yaw_deg: 30", tray);
  ASSERT_TRUE(scene) << scene.error().message;
  ASSERT_EQ(scene->parts.size(), 1u);
  const Eigen::Matrix3d R = scene->parts[0].X_WP.q.toRotationMatrix();
  EXPECT_NEAR(std::atan2(R(1, 0), R(0, 0)), 50 * std::numbers::pi / 180, 1e-12);
  // Turned further it does not fit.
  const auto askew = load_pocket(hole, "xy_m: [0.05, 0], yaw_deg: 30",
                                 replaced(tray, "key_1", "{name: key_1, yaw_deg: 10}"));
  expect_error(askew, "key_1 25.0 mm deep in plate");
}

TEST_F(PocketKeys, MistakesAreReported) {
  const auto polygon = [this](const std::string& corners) {
    return load_pocket("{polygon: {corners_m: " + corners + "}, depth_m: 0.02}");
  };
  expect_error(polygon("[[0, 0.02], [-0.012, -0.016], [0.019, 0.006], [-0.019, 0.006], [0.012, "
                       "-0.016]]"),
               "pockets.yaml:2:31: pockets.hole.polygon.corners_m: found an outline that winds "
               "around more than once, expected each corner once");
  expect_error(polygon("[[-0.01, -0.01], [0.01, 0.01], [0.01, -0.01], [-0.01, 0.01]]"),
               "found corner 1 that does not turn left");
  std::string many;
  for (int i = 0; i < 25; ++i) {
    const double angle = 2 * std::numbers::pi * i / 25;
    many += (i == 0 ? "[[" : ", [") + std::to_string(0.02 * std::cos(angle)) + ", " +
            std::to_string(0.02 * std::sin(angle)) + ']';
  }
  expect_error(polygon(many + ']'), "found 25 corners, expected 3 to 24 corners [x, y]");
  expect_error(load_pocket("{rectangle: {size_m: [0.01, 0.02], corner_radius_m: 0.0051}, depth_m: "
                           "0.02}"),
               "pockets.hole.rectangle.corner_radius_m: found 0.0051, expected a number in [0, "
               "0.005]");
  expect_error(load_pocket("{rectangle: {size_m: [0.01, 0]}, depth_m: 0.02}"),
               "pockets.hole.rectangle.size_m[1]: found 0, expected a number in (0, 1000]");
  expect_error(load_pocket("{rectangle: {size_m: [0.01, 0.01]}, top_radius_m: 0.01, depth_m: "
                           "0.02}"),
               "pockets.hole.top_radius_m: found top_radius_m of a pocket that is not round");
  expect_error(load_pocket("{rectangle: {size_m: [0.01, 0.01]}, polygon: {corners_m: [[0, 0], "
                           "[0.01, 0], [0, 0.01]]}, depth_m: 0.02}"),
               "pockets.hole: found rectangle beside polygon");
  expect_error(load_pocket("{rectangle: {size_m: [0.01, 0.01]}, depth_m: 0.03}"),
               "tray_types.plate.slots[0]: found slot a with a pocket 30 mm deep, expected less "
               "than the tray's thickness of 30 mm");
}

TEST_F(PocketKeys, PocketsLieInTheTrayAndApart) {
  expect_error(load_pocket(kKeyHole, "xy_m: [0.098, 0]"),
               "tray_types.plate.slots[1]: found slot b with a pocket that reaches 2.05 mm beyond "
               "the tray's edge, expected one within the tray's top face");
  expect_error(load_pocket(kKeyHole, "xy_m: [0.0961, 0], yaw_deg: 45"), "beyond the tray's edge");
  EXPECT_TRUE(load_pocket(kKeyHole, "xy_m: [0.0082, 0]"));
  expect_error(load_pocket(kKeyHole, "xy_m: [0.008, 0]"),
               "tray_types.plate.slots[1]: found slots a and b with pockets that overlap by 0.1 "
               "mm, expected pockets apart from each other");
  expect_error(load_pocket(kKeyHole, "xy_m: [0.0082, 0], yaw_deg: 30"), "pockets that overlap by");
  // Beside a round one, at its nearest corner.
  EXPECT_TRUE(load_pocket(kKeyHole, "xy_m: [0.05, 0]",
                          "      - {name: c, gear: key, pocket: round, xy_m: [0.0112, 0.0107]}\n"));
  expect_error(load_pocket(kKeyHole, "xy_m: [0.05, 0]",
                           "      - {name: c, gear: key, pocket: round, xy_m: [0.0111, 0.0105]}\n"),
               "slots a and c with pockets that overlap by");
  // A chamfer counts for the mouth.
  expect_error(load_pocket("{rectangle: {size_m: [0.0081, 0.0071]}, depth_m: 0.02, chamfer_m: "
                           "0.001}",
                           "xy_m: [0.0099, 0]"),
               "pockets that overlap by 0.2 mm");
}

TEST_F(PocketKeys, AGearNeedsRoomForItsHubAndARimForItsDisc) {
  const std::string gear =
      "gear_types:\n  wheel:\n    disc: {radius_m: 0.02, height_m: 0.006}\n    hub: "
      "{top_radius_m: 0.01, bottom_radius_m: 0.01, height_m: 0.01}\n    peg: {radius_m: 0.004, "
      "height_m: 0.01}\n    mass_kg: 0.01\n";
  const auto square = [&](double side) {
    const std::string size = std::to_string(side);
    return load_pocket("{rectangle: {size_m: [" + size + ", " + size + "]}, depth_m: 0.02}",
                       "xy_m: [0.07, 0]",
                       "      - {name: c, gear: wheel, pocket: hole, xy_m: [-0.06, 0]}\n" + gear);
  };
  EXPECT_TRUE(square(0.021));
  expect_error(square(0.019),
               "found slot c of gear type wheel with a hub radius of 10 mm at the "
               "disc, expected at most the 9.5 mm from the slot's centre to the "
               "pocket's wall");
  expect_error(square(0.041),
               "found slot c of gear type wheel with a disc radius of 20 mm, "
               "expected more than the 20.5 mm from the slot's centre to the mouth");
}

}  // namespace
}  // namespace aprsim::scene
