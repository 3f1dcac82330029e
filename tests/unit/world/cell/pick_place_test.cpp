// A pick and place of each robot in the default cell, in stepped time: friction only.

#include "tests/support/pick_place.hpp"

#include <gtest/gtest.h>

namespace aprsim::test {
namespace {

void expect_clean(const PickPlaceReport& report) {
  EXPECT_GT(report.lift_m, 0.04);
  // With what the mount gives way under fingers and gear.
  EXPECT_LT(report.slip_m, 2e-4);
  EXPECT_LT(report.place_error_m, 1e-3);
  EXPECT_LT(report.tilt_rad, 0.01);
  EXPECT_TRUE(report.resting);
  EXPECT_LT(report.max_penetration_m, 5e-4);
}

void print(const char* what, const PickPlaceReport& r) {
  std::printf(
      "%s: lift %.1f mm, slip %.2f um, place error %.1f um, tilt %.2e rad, penetration %.0f um, "
      "resting %d\n",
      what, r.lift_m * 1e3, r.slip_m * 1e6, r.place_error_m * 1e6, r.tilt_rad,
      r.max_penetration_m * 1e6, r.resting);
}

TEST(PickPlace, FanucMovesALargeGearIntoAKit) {
  CellScript cell(load_scene("aprs"));
  const auto report = pick_and_place(cell, 0, "part_large_gear_1", "kit_m2l1_vessel_1", "lg_1", 0);
  print("fanuc large", report);
  expect_clean(report);
}

TEST(PickPlace, FanucMovesAMediumGearIntoAKit) {
  CellScript cell(load_scene("aprs"));
  const auto report = pick_and_place(cell, 0, "part_medium_gear_1", "kit_m2l1_vessel_2", "mg_1", 0);
  print("fanuc medium", report);
  expect_clean(report);
}

TEST(PickPlace, MotomanMovesALargeGearIntoAKitOnTheBelt) {
  CellScript cell(load_scene("aprs"));
  const auto report = pick_and_place(cell, 1, "part_large_gear_5", "kit_s2l2_vessel_2", "lg_2", 0);
  print("motoman large", report);
  expect_clean(report);
}

TEST(PickPlace, MotomanMovesASmallGear) {
  CellScript cell(load_scene("aprs"));
  const auto report = pick_and_place(cell, 1, "part_small_gear_2", "kit_s2l2_vessel_2", "sg_1", 0);
  print("motoman small", report);
  expect_clean(report);
}

TEST(PickPlace, AnOffCentreGraspStillHolds) {
  CellScript cell(load_scene("aprs"));
  const auto report =
      pick_and_place(cell, 0, "part_large_gear_1", "kit_m2l1_vessel_1", "lg_1", 0, {0.001, 0.001});
  print("fanuc off centre", report);
  expect_clean(report);
}

}  // namespace
}  // namespace aprsim::test
