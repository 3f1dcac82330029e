#include "clients/wires/vision_frame.hpp"

#include <gtest/gtest.h>

namespace aprsim::client {
namespace {

TEST(VisionFrame, HoldsEveryObjectOfTheLine) {
  const auto objects = decode_vision_line(
      "part_large_gear,0.5000,100.250,-50.125,0.98,P,large_gear_vessel,-1.5,0,2e2,1,PT,\r\n");
  ASSERT_TRUE(objects) << objects.error().message;
  ASSERT_EQ(objects->size(), 2U);
  const VisionObject& gear = objects->front();
  EXPECT_EQ(gear.name, "part_large_gear");
  EXPECT_EQ(gear.kind, "P");
  EXPECT_TRUE(gear.detected);
  EXPECT_DOUBLE_EQ(gear.rotation_rad, 0.5);
  EXPECT_DOUBLE_EQ(gear.x_m, 0.10025);
  EXPECT_DOUBLE_EQ(gear.y_m, -0.050125);
  EXPECT_DOUBLE_EQ(gear.score, 0.98);
  EXPECT_EQ(objects->back().kind, "PT");
  EXPECT_DOUBLE_EQ(objects->back().y_m, 0.2);
}

TEST(VisionFrame, ASlotWithoutNumbersIsNotDetected) {
  const auto objects = decode_vision_line("gear, , , , , P, gear,1,,3,4,P,");
  ASSERT_TRUE(objects) << objects.error().message;
  ASSERT_EQ(objects->size(), 2U);
  for (const auto& object : *objects) {
    EXPECT_EQ(object.name, "gear");
    EXPECT_EQ(object.kind, "P");
    EXPECT_FALSE(object.detected);
    EXPECT_EQ(object.rotation_rad, 0);
    EXPECT_EQ(object.score, 0);
  }
}

TEST(VisionFrame, AnEmptyLineHoldsNothing) {
  const auto objects = decode_vision_line("\n");
  ASSERT_TRUE(objects);
  EXPECT_TRUE(objects->empty());
}

TEST(VisionFrame, AnythingElseIsAFailure) {
  for (const char* line : {"gear,1,2,3,4,P,gear", "gear,1,2,3,4", "gear,one,2,3,4,P,",
                           "gear,1,2,nan,4,P,", "gear,1,2 mm,3,4,P,"}) {
    const auto objects = decode_vision_line(line);
    ASSERT_FALSE(objects) << line;
    EXPECT_EQ(objects.error().kind, FailureKind::kConnection) << line;
  }
}

}  // namespace
}  // namespace aprsim::client
