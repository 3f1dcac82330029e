#include "protocols/vision/vision_line.hpp"

#include <gtest/gtest.h>

#include "tests/support/vision_client.hpp"

namespace aprsim::vision_server {
namespace {

api::CellDescription three_bodies() {
  api::CellDescription cell;
  cell.bodies.resize(3);
  cell.bodies[0].type = "sku_part_large_gear";
  cell.bodies[1].type = "sku_large_gear_vessel";
  cell.bodies[1].kind = api::BodyKind::kPartTray;
  cell.bodies[2].type = "sku_kit_m2l1_vessel";
  cell.bodies[2].kind = api::BodyKind::kKitTray;
  return cell;
}

TEST(VisionLine, SixFieldsAnObjectATrailingCommaAndALineFeed) {
  api::VisionFrame frame;
  frame.detections = {{1, 0.35821, -0.1607, -2.55, 0.92}, {0, 0.5, 0, 0, 1}, {2, -1, 1, 3.14, 0.8}};
  EXPECT_EQ(vision_line(frame, three_bodies(), false),
            "sku_large_gear_vessel,-2.5500,358.210,-160.700,0.92,PT,"
            "sku_part_large_gear,0.0000,500.000,0.000,1.00,P,"
            "sku_kit_m2l1_vessel,3.1400,-1000.000,1000.000,0.80,KT,\n");
}

TEST(VisionLine, CanReportAnEmptySlotForAMissedPart) {
  api::VisionFrame frame;
  frame.detections = {{1, 0.1, 0.2, 0.3, 1}};
  const auto objects = test::parse_vision_line(vision_line(frame, three_bodies(), true));
  ASSERT_EQ(objects.size(), 3U);
  EXPECT_TRUE(objects[0].seen);
  EXPECT_FALSE(objects[1].seen);
  EXPECT_EQ(objects[1].name, "sku_part_large_gear");
  EXPECT_EQ(objects[1].type, "P");
  EXPECT_FALSE(objects[2].seen);
  EXPECT_EQ(objects[2].type, "KT");
  frame.detections.clear();
  EXPECT_EQ(vision_line(frame, three_bodies(), true),
            "sku_part_large_gear,,,,,P,sku_large_gear_vessel,,,,,PT,sku_kit_m2l1_vessel,,,,,KT,\n");
}

TEST(VisionLine, AnEmptyFrameIsABlankLine) {
  EXPECT_EQ(vision_line({}, three_bodies(), false), "\n");
}

// A line as a lab's camera sent it in 2018, cut short: what the parser of these tests must take.
TEST(VisionLine, TheTestsParserReadsALabLine) {
  const auto objects = test::parse_vision_line(
      "sku_part_large_gear,0.00,384.96,-206.83,0.99,P,sku_part_large_gear,,,,,P,"
      "sku_large_gear_vessel,-2.55,358.21,-160.70,0.92,PT,\r\n");
  ASSERT_EQ(objects.size(), 3U);
  EXPECT_EQ(objects[0].x_mm, 384.96);
  EXPECT_FALSE(objects[1].seen);
  EXPECT_EQ(objects[2].rotation_rad, -2.55);
  EXPECT_EQ(objects[2].type, "PT");
  EXPECT_THROW(test::parse_vision_line("a,1,2,3,4,P,b\n"), std::runtime_error);
}

}  // namespace
}  // namespace aprsim::vision_server
