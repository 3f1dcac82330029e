// The scenes against the settings that the APRS framework ships for them: the camera's
// detections from each robot's inspection pose, and the grip poses that follow from them.

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/cell_script.hpp"

namespace aprsim::test {
namespace {

constexpr double kSettingDegree = std::numbers::pi / 180;

/// A box of the cart limits, in x and y [mm].
struct CartBox {
  double min_x, max_x, min_y, max_y;
};

/// The settings of one robot, in their millimetres and degrees.
struct Settings {
  const char* name;
  const char* scene;
  int robot;
  Eigen::Vector3d look_for;     ///< lookForXYZ
  double yaw_deg;               ///< of RPY, whose other angles are 180 and 0
  double rotation_offset_deg;   ///< rotationOffset, added to the yaw of trays
  double grip_z;                ///< transform.point.z: of every grip
  std::vector<CartBox> limits;  ///< cartLimits.csv
  std::set<std::string> trays;  ///< of which the cached queries have slots
  int kits, part_trays, gears;  ///< that are to be seen
};
void PrintTo(const Settings& shown, std::ostream* out) { *out << shown.name; }

const std::vector<CartBox> kFanucLimits = {{100, 200, -200, 200}, {225, 700, -275, 275}};
const std::vector<CartBox> kMotomanLimits = {
    {-100, 500, -50, 700}, {650, 850, -300, 410}, {500, 850, -300, 250}};
const std::set<std::string> kFanucTrays = {"sku_kit_m2l1_vessel", "sku_medium_gear_vessel",
                                           "sku_large_gear_vessel"};
const std::set<std::string> kMotomanTrays = {"sku_kit_s2l2_vessel", "sku_small_gear_vessel",
                                             "sku_large_gear_vessel"};

const Eigen::Vector3d kFanucLooks(150, 80, 180), kMotomanLooks(316.553, 177.327, 133.66);

const Settings kAll[] = {
    {"sim_fanuc", "aprs", 0, kFanucLooks, -135, 0, 0, kFanucLimits, kFanucTrays, 2, 2, 6},
    {"sim_motoman", "aprs", 1, kMotomanLooks, 0, 0, -288, kMotomanLimits, kMotomanTrays, 2, 3, 8},
    {"lab_fanuc", "aprs_lab", 0, kFanucLooks, -135, 90, -97, kFanucLimits, kFanucTrays, 2, 2, 6},
    {"lab_motoman", "aprs_lab", 1, kMotomanLooks, 0, -90, -230, kMotomanLimits, kMotomanTrays, 2, 3,
     8},
};

/// The commanded point in the robot's CRCL frame.
Eigen::Isometry3d pose(const Eigen::Vector3d& p_mm, double yaw_deg) {
  return Eigen::Translation3d(p_mm * 1e-3) *
         Eigen::AngleAxisd(yaw_deg * kSettingDegree, Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX());
}

class FrameworkSettings : public testing::TestWithParam<Settings> {
 protected:
  FrameworkSettings() : cell_(load_scene(GetParam().scene)) {
    const auto& robot = description();
    X_WR_ = robot.X_WB.isometry() * robot.X_BR.isometry();
    X_PT_ = robot.tool_point_F ? robot.tool_point_F->isometry().inverse() * robot.X_FT.isometry()
                               : Eigen::Isometry3d::Identity();
  }

  [[nodiscard]] const api::RobotDescription& description() const {
    return cell_.world.description()->robots[static_cast<std::size_t>(GetParam().robot)];
  }
  [[nodiscard]] const api::BodyDescription& body(const api::VisionDetection& seen) const {
    return cell_.world.description()->bodies[static_cast<std::size_t>(seen.body)];
  }

  /// Detections of the camera from the robot's inspection pose.
  std::vector<api::VisionDetection> look() {
    const Settings& s = GetParam();
    cell_.act(s.robot, api::InitRobot{});
    cell_.act(s.robot, api::MoveTo{Pose::from(pose(s.look_for, s.yaw_deg)), false});
    cell_.advance(400);  // frames from before the motion's end are out
    return cell_.now.robots.at(static_cast<std::size_t>(s.robot)).vision.detections;
  }

  CellScript cell_;
  Eigen::Isometry3d X_WR_, X_PT_;
};

TEST_P(FrameworkSettings, TheCameraShowsWhatTheyHaveSlotsForAndNothingElse) {
  int kits = 0, part_trays = 0, gears = 0;
  for (const auto& seen : look()) {
    const auto& what = body(seen);
    if (what.kind == api::BodyKind::kGear) {
      ++gears;
      continue;
    }
    EXPECT_TRUE(GetParam().trays.contains(what.type)) << what.name << ": " << what.type;
    ++(what.kind == api::BodyKind::kKitTray ? kits : part_trays);
  }
  EXPECT_EQ(kits, GetParam().kits);
  EXPECT_EQ(part_trays, GetParam().part_trays);
  EXPECT_EQ(gears, GetParam().gears);
}

// A tray of which one slot, with the gear in it, is outside is passed over as a whole, or ends the
// job. The limits are meant in what the camera reports.
TEST_P(FrameworkSettings, EveryTrayLiesWithinOneBoxOfTheCartLimits) {
  const auto& limits = GetParam().limits;
  const std::map<std::string, double> radius_mm = {
      {"sku_part_small_gear", 25}, {"sku_part_medium_gear", 35}, {"sku_part_large_gear", 50}};
  for (const auto& seen : look()) {
    const auto& tray = body(seen);
    if (tray.kind == api::BodyKind::kGear) continue;
    const bool within = std::ranges::any_of(limits, [&](const CartBox& box) {
      return std::ranges::all_of(tray.slots, [&](const api::SlotDescription& slot) {
        const double yaw = seen.rotation_rad + GetParam().rotation_offset_deg * kSettingDegree;
        const double c = std::cos(yaw), s = std::sin(yaw);
        const double x = 1e3 * (seen.x_m + c * slot.X_PS.p.x() - s * slot.X_PS.p.y());
        const double y = 1e3 * (seen.y_m + s * slot.X_PS.p.x() + c * slot.X_PS.p.y());
        const double r = radius_mm.at(slot.gear_type);
        return x - r >= box.min_x && x + r <= box.max_x && y - r >= box.min_y && y + r <= box.max_y;
      });
    });
    EXPECT_TRUE(within) << tray.name << " reported at " << 1e3 * seen.x_m << ", " << 1e3 * seen.y_m;
  }
}

// As they reckon, from a tray's place and yaw; but for what a calibration stretches.
TEST_P(FrameworkSettings, TheGearsAreSeenWhereTheTraysSlotsAre) {
  const auto seen_now = look();
  int slots = 0;
  for (const auto& seen : seen_now) {
    const auto& tray = body(seen);
    if (tray.kind != api::BodyKind::kPartTray) continue;
    const double yaw = seen.rotation_rad + GetParam().rotation_offset_deg * kSettingDegree;
    for (const auto& slot : tray.slots) {
      const Eigen::Vector2d p_slot =
          Eigen::Vector2d(seen.x_m, seen.y_m) + Eigen::Rotation2Dd(yaw) * slot.X_PS.p.head<2>();
      double nearest_m = 1;
      for (const auto& other : seen_now) {
        if (body(other).type != slot.gear_type) continue;
        nearest_m = std::min(nearest_m, (Eigen::Vector2d(other.x_m, other.y_m) - p_slot).norm());
      }
      EXPECT_LT(nearest_m, 0.004) << tray.name << ' ' << slot.name;
      ++slots;
    }
  }
  EXPECT_GT(slots, 0);
}

// Their height closes the fingers on the peg, clear of the disc.
TEST_P(FrameworkSettings, TheirHeightGripsThePegs) {
  int gears = 0;
  for (const auto& seen : look()) {
    const auto& gear = body(seen);
    if (gear.kind != api::BodyKind::kGear) continue;
    const Eigen::Isometry3d X_WG =
        cell_.now.bodies[static_cast<std::size_t>(seen.body)].X_WB.isometry();
    const Eigen::Vector3d p_RG = X_WR_.inverse() * X_WG.translation();
    const Eigen::Vector3d p_mm(1e3 * p_RG.x(), 1e3 * p_RG.y(), GetParam().grip_z);
    const Eigen::Isometry3d X_RT = pose(p_mm, GetParam().yaw_deg) * X_PT_;
    const double tips = X_RT.translation().z() - p_RG.z();
    EXPECT_GT(tips, gear.disc_height_m + 0.002) << gear.name;
    EXPECT_LT(tips, gear.peg_top_m - 0.008) << gear.name << ": that much of the peg is held";
    EXPECT_LT((X_RT.translation() - p_RG).head<2>().norm(), 1e-6) << gear.name;
    ++gears;
  }
  EXPECT_GT(gears, 0);
}

// Over a slot and straight down to where a part is let go.
TEST_P(FrameworkSettings, TheRobotReachesEverySlotAsTheyTurnTheTool) {
  const Settings& s = GetParam();
  const auto seen_now = look();
  for (const auto& seen : seen_now) {
    const auto& tray = body(seen);
    if (tray.kind == api::BodyKind::kGear) continue;
    for (const auto& slot : tray.slots) {
      const Eigen::Vector3d p_RS = X_WR_.inverse() * cell_.X_WS(tray.name, slot.name).translation();
      for (const double up : {50.0, 5.0, 50.0}) {
        const Eigen::Vector3d p_mm(1e3 * p_RS.x(), 1e3 * p_RS.y(), s.grip_z + up);
        const bool straight = up < 50;
        EXPECT_NO_THROW(
            cell_.act(s.robot, api::MoveTo{Pose::from(pose(p_mm, s.yaw_deg)), straight}))
            << tray.name << ' ' << slot.name << ", " << up << " mm above";
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Shipped, FrameworkSettings, testing::ValuesIn(kAll),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace aprsim::test
