#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "clients/aprsim/demo/cell_view.hpp"
#include "clients/aprsim/demo/geometry.hpp"
#include "clients/aprsim/demo/grasp.hpp"
#include "clients/aprsim/demo/reach.hpp"

namespace aprsim::client {
namespace {

void set_position(v1::Pose& pose, double x, double y, double z) {
  pose.mutable_position_m()->set_x(x);
  pose.mutable_position_m()->set_y(y);
  pose.mutable_position_m()->set_z(z);
  pose.mutable_orientation()->set_w(1);
}

/// A part tray with gears in slots 50 mm apart along x, a kit tray with one free slot of that type
/// and one of another, on a belt of 3 m by 0.6 m.
struct TwoTrays {
  v1::CellDescription cell;
  v1::Snapshot snapshot;

  explicit TwoTrays(double kit_y) {
    set_position(*cell.mutable_conveyor()->mutable_belt_in_world(), 0, 0, 0.9);
    cell.mutable_conveyor()->set_length_m(3);
    cell.mutable_conveyor()->set_width_m(0.6);
    auto& part = add_tray("part", v1::BODY_KIND_PART_TRAY, 0.3, 0);
    add_slot(part, "s1", "small", -0.025);
    add_slot(part, "s2", "small", 0.025);
    auto& kit = add_tray("kit", v1::BODY_KIND_KIT_TRAY, 0.5, kit_y);
    add_slot(kit, "k1", "small", 0);
    add_slot(kit, "k2", "large", 0.08);
    add_gear("g1", 0.275, 0);
    add_gear("g2", 0.325, 0);
  }

  v1::TrayGeometry& add_tray(const char* name, v1::BodyKind kind, double x, double y) {
    auto& body = *cell.add_bodies();
    body.set_name(name);
    body.set_kind(kind);
    set_position(*snapshot.add_bodies()->mutable_body_in_world(), x, y, 0.92);
    return *body.mutable_tray();
  }
  static void add_slot(v1::TrayGeometry& tray, const char* name, const char* type, double x) {
    auto& slot = *tray.add_slots();
    slot.set_name(name);
    slot.set_gear_type(type);
    set_position(*slot.mutable_slot_in_tray(), x, 0, 0);
  }
  void add_gear(const char* name, double x, double y) {
    auto& body = *cell.add_bodies();
    body.set_name(name);
    body.set_type("small");
    body.set_kind(v1::BODY_KIND_GEAR);
    body.mutable_gear()->set_disc_height_m(0.006);
    body.mutable_gear()->set_peg_radius_m(0.0038);
    body.mutable_gear()->set_peg_top_m(0.0225);
    auto& state = *snapshot.add_bodies();
    state.set_resting(true);
    set_position(*state.mutable_body_in_world(), x, y, 0.92);
  }
};

TEST(CellView, FindsGearsInSlotsAndTransfersThatFit) {
  const TwoTrays cell(0);
  const CellView view(cell.cell, cell.snapshot);
  ASSERT_EQ(view.slots().size(), 4U);
  EXPECT_EQ(view.slot("part", "s1")->gear, "g1");
  EXPECT_EQ(view.slot("kit", "k1")->gear, "");
  EXPECT_TRUE(view.slot("kit", "k1")->on_belt);
  const auto transfers = view.transfers({0, 0, 0}, false, "");
  ASSERT_EQ(transfers.size(), 2U);
  EXPECT_EQ(transfers[0].to.slot, "k1");
  // The gear nearer to half a metre from the base comes first.
  EXPECT_EQ(transfers[0].gear.name, "g2");
}

TEST(CellView, TransfersWhollyOnOrBesideTheBeltComeFirst) {
  TwoTrays cell(0);
  TwoTrays::add_slot(cell.add_tray("beside", v1::BODY_KIND_KIT_TRAY, 0.5, 0.5), "b1", "small", 0);
  const CellView view(cell.cell, cell.snapshot);
  EXPECT_TRUE(view.slot("kit", "k1")->on_belt);
  EXPECT_FALSE(view.slot("beside", "b1")->on_belt);
  // Seen from a base half a metre from the one beside the belt.
  const Eigen::Vector3d p_WB(0.3, 1, 0);
  EXPECT_EQ(view.transfers(p_WB, true, "").front().to.tray, "kit");
  EXPECT_EQ(view.transfers(p_WB, false, "").front().to.tray, "beside");
  EXPECT_EQ(view.transfers(p_WB, false, "").size(), 4U);
}

TEST(CellView, GearsOfThePreferredTrayComeFirst) {
  TwoTrays cell(0);
  TwoTrays::add_slot(cell.add_tray("brought", v1::BODY_KIND_PART_TRAY, -0.4, 0), "p1", "small", 0);
  cell.add_gear("g3", -0.4, 0);
  const CellView view(cell.cell, cell.snapshot);
  EXPECT_NE(view.transfers({0, 0.5, 0}, true, "").front().gear.name, "g3");
  EXPECT_EQ(view.transfers({0, 0.5, 0}, true, "brought").front().gear.name, "g3");
}

TEST(CellView, AnOccupiedSlotIsNotOffered) {
  TwoTrays cell(0);
  cell.add_gear("g3", 0.512, 0);  // beside the slot's centre, yet in the way
  const CellView view(cell.cell, cell.snapshot);
  EXPECT_TRUE(view.transfers({0, 0, 0}, false, "").empty());
}

TEST(CellView, ReportsWhetherGearsAreLeft) {
  TwoTrays cell(0);
  EXPECT_TRUE(CellView(cell.cell, cell.snapshot).has_gear_in_part_tray());
  for (const int gear : {2, 3}) {
    set_position(*cell.snapshot.mutable_bodies(gear)->mutable_body_in_world(), 2, 2, 0);
  }
  EXPECT_FALSE(CellView(cell.cell, cell.snapshot).has_gear_in_part_tray());
}

SlotView slot_at(const char* name, double x, double y, double z) {
  SlotView slot;
  slot.tray = "tray";
  slot.slot = name;
  slot.X_WS = Eigen::Isometry3d(Eigen::Translation3d(x, y, z));
  return slot;
}

TEST(Reach, PlacesBeyondAnUnreachableOneAreExcluded) {
  Reach reach({1, 0, 0});
  EXPECT_FALSE(reach.excludes(slot_at("a", 2, 0, 0.5)));
  reach.exclude({slot_at("a", 2, 0, 0.5), /*too_far=*/true});
  EXPECT_TRUE(reach.excludes(slot_at("a", 2, 0, 0.5)));
  EXPECT_TRUE(reach.excludes(slot_at("behind", -0.5, 0, 0.5))) << "round the base";
  EXPECT_FALSE(reach.excludes(slot_at("nearer", 1.9, 0, 0.5)));
  EXPECT_FALSE(reach.excludes(slot_at("higher", 2.1, 0, 0.8))) << "another height, another reach";
}

TEST(Reach, ARefusalForAnotherReasonExcludesOnlyItsPlace) {
  Reach reach({0, 0, 0});
  reach.exclude({slot_at("a", 1, 0, 0), /*too_far=*/false});
  EXPECT_TRUE(reach.excludes(slot_at("a", 1, 0, 0)));
  EXPECT_FALSE(reach.excludes(slot_at("b", 1.2, 0, 0)));
}

TEST(Geometry, ToolPointsDownWithItsYaw) {
  const auto X = tool_down({1, 2, 3}, 0.7);
  EXPECT_NEAR(X.linear().determinant(), 1, 1e-12);
  EXPECT_NEAR(X.linear()(2, 2), -1, 1e-12);
  EXPECT_NEAR(tool_yaw(X), 0.7, 1e-12);
  const auto pose = crcl_pose_mm(X);
  EXPECT_EQ(pose.point, (crcl::Vector{1000, 2000, 3000}));
  EXPECT_NEAR(pose.x_axis.x, std::cos(0.7), 1e-12);
  EXPECT_EQ(pose.z_axis.z, -1);
}

TEST(Grasp, FingersTurnAwayFromTheNeighboursPeg) {
  const TwoTrays cell(0);
  const CellView view(cell.cell, cell.snapshot);
  v1::GripperDescription gripper;
  gripper.set_gap_open_m(0.041);
  const auto transfer = view.transfers({0, 0, 0}, false, "").front();
  const Eigen::Vector3d p_WT = transfer.gear.X_WP.translation() +
                               Eigen::Vector3d(0, 0, grasp_height_m(transfer.gear.geometry));
  // Fingers travel along the tool's y: at a yaw of 90 degrees that is the row of gears.
  const double along = std::numbers::pi / 2;
  EXPECT_LT(finger_clearance_m(view, transfer.gear.name, gripper, p_WT, along), 0);
  EXPECT_GT(finger_clearance_m(view, transfer.gear.name, gripper, p_WT, 0), 0.005);
  // High over the trays nothing is in the way.
  EXPECT_GT(finger_clearance_m(view, transfer.gear.name, gripper,
                               p_WT + Eigen::Vector3d(0, 0, 0.05), along),
            0.005);
  const auto yaws = rank_yaws(view, transfer, gripper, along);
  ASSERT_FALSE(yaws.empty());
  EXPECT_GT(finger_clearance_m(view, transfer.gear.name, gripper, p_WT, yaws.front()), 0.005);
  EXPECT_LT(finger_clearance_m(view, transfer.gear.name, gripper, p_WT, yaws.back()), 0);
}

}  // namespace
}  // namespace aprsim::client
