#include "tests/support/kitting_snapshot.hpp"

#include <utility>

namespace aprsim::test {
namespace {

api::RobotDescription make_robot() {
  api::RobotDescription robot;
  robot.name = "fanuc";
  robot.model = "fanuc_lrmate200id";
  robot.joints = {{"joint_1", -2.9, 2.9, 7.8, 230}, {"joint_2", -1.7, 2.5, 6.6, 260}};
  robot.X_WB.p = {-0.169, -1.14, 0.934};
  robot.X_FT.p = {0.194, 0, 0};
  robot.gripper = {.stroke_m = 0.0075, .gap_open_m = 0.02, .gap_closed_m = 0.005, .force_n = 60};
  robot.max_trans_speed_m_s = 1.5;
  return robot;
}

api::BodyDescription make_gear(std::string name) {
  api::BodyDescription gear;
  gear.name = std::move(name);
  gear.type = "sku_part_large_gear";
  gear.mass_kg = 0.033;
  gear.disc_radius_m = 0.05;
  gear.disc_height_m = 0.006;
  gear.peg_radius_m = 0.0038;
  gear.peg_top_m = 0.026;
  return gear;
}

api::BodyDescription make_tray() {
  api::BodyDescription tray;
  tray.name = "kit_1";
  tray.type = "sku_kit_m2l1_vessel";
  tray.kind = api::BodyKind::kKitTray;
  tray.mass_kg = 0.2;
  tray.slots = {{"lg1", "sku_part_large_gear", Pose{{0.039, 0.0075, 0}, {}}}};
  tray.box_min = {-0.08, -0.095, -0.017};
  tray.box_max = {0.08, 0.095, 0};
  return tray;
}

}  // namespace

api::SnapshotPtr kitting_snapshot(int more_gears) {
  auto cell = std::make_shared<api::CellDescription>();
  cell->scene = "fake";
  cell->seed = 7;
  cell->step_size = std::chrono::milliseconds(1);
  cell->robots = {make_robot()};
  cell->has_conveyor = true;
  cell->conveyor = {.X_WC = {},
                    .length_m = 3,
                    .width_m = 0.6,
                    .max_speed_m_s = 0.32768,
                    .max_accel_m_s2 = 0.5,
                    .max_decel_m_s2 = 0.6,
                    .emergency_decel_m_s2 = 2,
                    .photo_eyes = {{.name = "eye", .x_m = 1}}};
  cell->light_curtain = {.X_WK = {},
                         .beams = 3,
                         .pitch_m = 0.04,
                         .range_m = 2.4,
                         .reaction = api::CurtainReaction::kBeltStop};
  cell->light_curtain->X_WK.p = {-1.2, -1.75, 0.3};
  cell->bodies = {make_gear("gear_1"), make_tray()};
  cell->fixed = {"floor", "table"};
  for (int i = 0; i < more_gears; ++i) {
    cell->bodies.push_back(make_gear("gear_in_a_long_row_number_" + std::to_string(i + 2)));
  }
  auto snapshot = std::make_shared<api::Snapshot>();
  snapshot->step = 100;
  snapshot->time = std::chrono::milliseconds(100);
  snapshot->speed_target = 1.0;
  snapshot->robots.resize(1);
  snapshot->robots[0].joints[1].position_rad = 0.25;
  snapshot->robots[0].gripper.separation_m = 0.0077;
  snapshot->robots[0].gripper.force_n = {59, 61};
  snapshot->robots[0].gripper.holding = true;
  snapshot->robots[0].gripper.held_body = 0;
  snapshot->robots[0].action.kind = api::ActionKind::kMoveTo;
  snapshot->robots[0].X_RG = Pose{{0.3, 0.1, 0.2}, Eigen::Quaterniond::Identity()};
  snapshot->bodies.resize(cell->bodies.size());
  snapshot->bodies[0].X_WB.p = {0.1, -1.0, 0.95};
  snapshot->bodies[1].resting = true;
  snapshot->bodies[1].group_kind = api::GroupKind::kMerged;
  snapshot->bodies[1].group = 0;
  snapshot->contact_count = 12;
  using Side = api::ContactSide::Kind;
  snapshot->contacts = {{{Side::kRobot, 0, 2}, {Side::kBody, 0}, {0.1, -1, 0.96}, {0, 60, 0}},
                        {{Side::kBody, 1}, {Side::kFixed, 1}, {0, 0, 0.93}, {0, 0, 2}}};
  snapshot->cell = std::move(cell);
  return snapshot;
}

}  // namespace aprsim::test
