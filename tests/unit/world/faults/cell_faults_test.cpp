// The effect of each fault of the belt, the parts, the cameras and the light curtain, and its end.

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/unit/world/faults/fault_cell.hpp"

namespace aprsim::test {
namespace {

using namespace std::chrono_literals;

const char* const kBeltTray = "kit_s2l2_vessel_1";  // on the belt

double speed_of(const FaultCell& cell, const std::string& body) {
  return cell.now.bodies[cell.body(body)].v_W.norm();
}

// ---- the belt

TEST(BeltFaults, AJamStopsBeltAndEncoder) {
  FaultCell cell;
  cell.run_belt(0.1);
  cell.advance(600);
  ASSERT_NEAR(speed_of(cell, kBeltTray), 0.1, 1e-3);
  const auto id = cell.inject("belt-jam");
  cell.advance(200);
  EXPECT_EQ(cell.now.conveyor.speed_m_s, 0);
  EXPECT_TRUE(cell.now.conveyor.run);
  EXPECT_EQ(cell.now.conveyor.fault, api::DriveFault::kNone);
  EXPECT_GT(cell.now.conveyor.motor_current_a, 1) << "the motor is held at rest";
  EXPECT_LT(speed_of(cell, kBeltTray), 1e-4);
  cell.end(id);
  cell.advance(600);
  EXPECT_NEAR(cell.now.conveyor.speed_m_s, 0.1, 1e-9);
  EXPECT_NEAR(speed_of(cell, kBeltTray), 0.1, 1e-3);
}

TEST(BeltFaults, ASlippingBeltMovesLessThanItsEncoderSays) {
  FaultCell cell;
  cell.run_belt(0.1);
  const auto id = cell.inject("belt-slip", "", {{"share", 0.5}});
  cell.advance(1000);
  EXPECT_NEAR(cell.now.conveyor.speed_m_s, 0.1, 1e-9);
  EXPECT_NEAR(speed_of(cell, kBeltTray), 0.05, 1e-3);
  cell.end(id);
  cell.advance(300);
  EXPECT_NEAR(speed_of(cell, kBeltTray), 0.1, 1e-3);
}

TEST(BeltFaults, AtTheWrongSpeedItSaysSo) {
  FaultCell cell;
  cell.run_belt(0.1);
  const auto id = cell.inject("belt-wrong-speed", "", {{"factor", 0.5}});
  cell.advance(1000);
  EXPECT_NEAR(cell.now.conveyor.speed_setting_m_s, 0.1, 1e-12);
  EXPECT_NEAR(cell.now.conveyor.speed_m_s, 0.05, 1e-9);
  EXPECT_NEAR(speed_of(cell, kBeltTray), 0.05, 1e-3);
  cell.end(id);
  cell.advance(500);
  EXPECT_NEAR(cell.now.conveyor.speed_m_s, 0.1, 1e-9);
}

TEST(BeltFaults, InTheWrongDirectionItSaysSo) {
  FaultCell cell;
  cell.run_belt(0.1);
  const auto id = cell.inject("belt-wrong-direction");
  cell.advance(1000);
  EXPECT_TRUE(cell.now.conveyor.forward) << "as it is set";
  EXPECT_NEAR(cell.now.conveyor.speed_m_s, -0.1, 1e-9);
  cell.end(id);
  cell.advance(1500);
  EXPECT_NEAR(cell.now.conveyor.speed_m_s, 0.1, 1e-9);
}

TEST(BeltFaults, AFrozenEncoderReadsWhatItDid) {
  FaultCell cell;
  cell.run_belt(0.1);
  cell.advance(600);
  const double travel = cell.now.conveyor.travel_m;
  const auto id = cell.inject("belt-encoder-frozen");
  cell.run_belt(0.2);
  cell.advance(1000);
  EXPECT_EQ(cell.now.conveyor.travel_m, travel);
  EXPECT_NEAR(cell.now.conveyor.speed_m_s, 0.1, 1e-9);
  EXPECT_NEAR(speed_of(cell, kBeltTray), 0.2, 1e-3);
  cell.end(id);
  cell.advance();
  EXPECT_GT(cell.now.conveyor.travel_m, travel + 0.15) << "it has counted on";
  EXPECT_NEAR(cell.now.conveyor.speed_m_s, 0.2, 1e-9);
}

TEST(BeltFaults, APhotoEyeStuckOnReportsABeamThatIsClear) {
  FaultCell cell;
  cell.advance(10);
  const auto upstream = cell.now.conveyor.photo_eyes[0], before = cell.now.conveyor.photo_eyes[1];
  ASSERT_FALSE(before.broken);
  const auto id = cell.inject("photo-eye-stuck-on", "downstream");
  cell.advance(20);
  EXPECT_TRUE(cell.now.conveyor.photo_eyes[1].broken);
  EXPECT_EQ(cell.now.conveyor.photo_eyes[1].count, before.count + 1);
  EXPECT_EQ(cell.now.conveyor.photo_eyes[0].broken, upstream.broken);
  cell.end(id);
  cell.advance(20);
  EXPECT_FALSE(cell.now.conveyor.photo_eyes[1].broken);
}

TEST(BeltFaults, APhotoEyeStuckOffSeesNothing) {
  FaultCell cell;
  // A tray into the beam.
  const Eigen::Isometry3d X_WC = cell.now.cell->conveyor.X_WC.isometry();
  const double beam_C = cell.now.cell->conveyor.photo_eyes[1].x_m;
  const std::string tray = "kit_s2l2_vessel_2";
  const Eigen::Vector3d at_C = X_WC.inverse() * cell.X_WB(tray).translation();
  const Eigen::Vector3d by = X_WC.linear() * Eigen::Vector3d(beam_C - at_C.x(), 0, 0);
  cell.inject("tray-shifted", tray, {{"x", by.x()}, {"y", by.y()}});
  cell.advance(500);
  ASSERT_TRUE(cell.now.conveyor.photo_eyes[1].broken);
  const auto id = cell.inject("photo-eye-stuck-off", "downstream");
  cell.advance(20);
  EXPECT_FALSE(cell.now.conveyor.photo_eyes[1].broken);
  cell.end(id);
  cell.advance(20);
  EXPECT_TRUE(cell.now.conveyor.photo_eyes[1].broken);
}

TEST(BeltFaults, AJammedTrayStaysWhileTheOthersMove) {
  FaultCell cell;
  const std::string last = "small_gear_vessel_2";  // nothing behind it runs into it
  const auto id = cell.inject("tray-jammed", last, {{"distance", 10}});
  cell.run_belt(0.1);
  cell.advance(1500);
  const double x = cell.X_WB(last).translation().x();
  cell.advance(1000);
  EXPECT_NEAR(cell.X_WB(last).translation().x(), x, 1e-4);
  EXPECT_LT(speed_of(cell, "part_small_gear_5"), 1e-3);
  EXPECT_NEAR(speed_of(cell, kBeltTray), 0.1, 1e-2);
  EXPECT_TRUE(cell.now.world_fault.empty());
  cell.end(id);
  cell.advance(500);
  EXPECT_NEAR(speed_of(cell, last), 0.1, 1e-2);
}

// ---- parts

Eigen::Vector2d xy_of(const FaultCell& cell, const std::string& body) {
  return cell.X_WB(body).translation().head<2>();
}

TEST(PartFaults, AMissingPartIsInNobodysWayAndSight) {
  FaultCell cell;
  const std::string part = "part_medium_gear_1";
  const auto id = cell.inject("part-missing", part);
  cell.advance(300);
  EXPECT_TRUE(cell.now.bodies[cell.body(part)].lost_step);
  for (const auto& robot : cell.now.robots) {
    for (const auto& seen : robot.vision.detections) {
      EXPECT_NE(seen.body, static_cast<int>(cell.body(part)));
    }
  }
  EXPECT_EQ(cell.fault(id).note, "");
  const auto again = cell.inject("part-missing", part);
  cell.advance();
  EXPECT_NE(cell.fault(again).note.find("not in the cell"), std::string::npos);
}

TEST(PartFaults, SwappedPartsLieInEachOthersPlace) {
  FaultCell cell;
  const std::string one = "part_medium_gear_1", two = "part_large_gear_1";
  const Eigen::Vector2d first = xy_of(cell, one), second = xy_of(cell, two);
  cell.inject("part-swapped", one + ":" + two);
  cell.advance(2000);
  EXPECT_LT((xy_of(cell, one) - second).norm(), 0.03);
  EXPECT_LT((xy_of(cell, two) - first).norm(), 0.15)
      << "too large for its place, it lies on others";
  EXPECT_LT(cell.now.max_penetration_m, 1e-3);
  EXPECT_TRUE(cell.now.world_fault.empty());
}

TEST(PartFaults, AMisplacedPartLiesBesideItsPlace) {
  FaultCell cell;
  const std::string part = "part_large_gear_2";
  const Eigen::Vector2d before = xy_of(cell, part);
  cell.inject("part-misplaced", part, {{"x", 0.0}, {"y", 0.015}, {"yaw", 0.5}});
  cell.advance(1500);
  EXPECT_NEAR((xy_of(cell, part) - before).norm(), 0.015, 0.012);
  EXPECT_GT((xy_of(cell, part) - before).norm(), 0.002);
  EXPECT_TRUE(cell.now.bodies[cell.body(part)].resting);
}

TEST(PartFaults, UpsideDownItsPegIsBelow) {
  FaultCell cell;
  const std::string part = "part_large_gear_1";
  ASSERT_GT(cell.X_WB(part)(2, 2), 0.99);
  cell.inject("part-upside-down", part);
  cell.advance(2000);
  EXPECT_LT(cell.X_WB(part)(2, 2), -0.3);
  EXPECT_LT(speed_of(cell, part), 0.05);
}

TEST(PartFaults, AStrayPartLiesWhereItWasPut) {
  FaultCell cell;
  const std::string part = "part_large_gear_1";
  cell.inject("part-stray", part, {{"x", 0.3}, {"y", 0.3}, {"z", 0.5}});
  cell.advance(1000);
  EXPECT_LT((xy_of(cell, part) - Eigen::Vector2d(0.3, 0.3)).norm(), 0.05);
  EXPECT_NEAR(cell.X_WB(part).translation().z(), 0, 0.03) << "on the table there";
}

TEST(PartFaults, AShiftedTrayTakesItsPartsAlong) {
  FaultCell cell;
  const std::string tray = "medium_gear_vessel_1", part = "part_medium_gear_2";
  const Eigen::Vector2d tray_at = xy_of(cell, tray), part_at = xy_of(cell, part);
  const Eigen::Isometry3d in_tray = cell.X_WB(tray).inverse() * cell.X_WB(part);
  cell.inject("tray-shifted", tray, {{"x", 0.012}, {"y", 0.02}, {"yaw", 0.05}});
  cell.advance(1500);
  EXPECT_LT((xy_of(cell, tray) - tray_at - Eigen::Vector2d(0.012, 0.02)).norm(), 2e-3);
  EXPECT_GT((xy_of(cell, part) - part_at).norm(), 0.01);
  const Eigen::Isometry3d now = cell.X_WB(tray).inverse() * cell.X_WB(part);
  EXPECT_LT((now.translation() - in_tray.translation()).norm(), 1e-3) << "in its slot still";
  EXPECT_TRUE(cell.now.bodies[cell.body(tray)].resting);
}

// ---- cameras

class CameraFault : public testing::Test {
 protected:
  /// In the Fanuc's latest frame; null = not seen. The last one of several.
  const api::VisionDetection* seen(const std::string& body) {
    const api::VisionDetection* found = nullptr;
    for (const auto& one : frame().detections) {
      if (one.body == static_cast<int>(cell_.body(body))) found = &one;
    }
    return found;
  }
  const api::VisionFrame& frame() { return cell_.robot(kFanucArm).vision; }

  /// In the camera's frame.
  Eigen::Vector2d true_xy(const std::string& body) {
    const auto& about = cell_.description(kFanucArm);
    const Eigen::Isometry3d X_WV =
        about.X_WB.isometry() * about.X_BR.isometry() * about.X_RV.isometry();
    return (X_WV.inverse() * cell_.X_WB(body)).translation().head<2>();
  }
  double off(const std::string& body) {
    const auto* one = seen(body);
    return one ? (Eigen::Vector2d(one->x_m, one->y_m) - true_xy(body)).norm() : -1;
  }

  static constexpr int kFewFrames = 500;  // steps
  const std::string part_ = "part_medium_gear_1";
  FaultCell cell_;
};

TEST_F(CameraFault, AnOutageGivesNoFrames) {
  cell_.advance(kFewFrames);
  const auto id = cell_.inject("camera-outage", "fanuc");
  cell_.advance(200);  // those on their way come out
  const auto number = frame().number;
  const auto other = cell_.robot(kMotomanArm).vision.number;
  cell_.advance(kFewFrames);
  EXPECT_EQ(frame().number, number);
  EXPECT_GT(cell_.robot(kMotomanArm).vision.number, other);
  cell_.end(id);
  cell_.advance(kFewFrames);
  EXPECT_GT(frame().number, number + 3);
}

TEST_F(CameraFault, AFrozenCameraShowsWhatItSaw) {
  cell_.advance(kFewFrames);
  const auto before = frame();
  ASSERT_FALSE(before.detections.empty());
  const auto id = cell_.inject("camera-frozen", "fanuc");
  cell_.inject("part-missing", part_);
  cell_.advance(2 * kFewFrames);
  EXPECT_GT(frame().number, before.number + 5);
  EXPECT_EQ(frame().detections, before.detections);
  cell_.end(id);
  cell_.advance(kFewFrames);
  EXPECT_EQ(seen(part_), nullptr);
}

TEST_F(CameraFault, LateFramesComeLate) {
  cell_.advance(kFewFrames);
  const auto age = [&] { return seconds(cell_.now.time - frame().time); };
  const double usual = age();
  EXPECT_LT(usual, 0.25);
  const auto id = cell_.inject("camera-late", "fanuc", {{"delay", 1.0}});
  cell_.advance(3000);
  EXPECT_NEAR(age(), 1 + usual, 0.11);
  const auto number = frame().number;
  cell_.advance(1000);
  EXPECT_NEAR(static_cast<double>(frame().number - number), 10, 1) << "none is left out";
  cell_.end(id);
  cell_.advance(2000);
  EXPECT_LT(age(), 0.25);
}

TEST_F(CameraFault, OneObjectCanBeLost) {
  cell_.advance(kFewFrames);
  ASSERT_NE(seen(part_), nullptr);
  const auto id = cell_.inject("camera-loses-part", "fanuc:" + part_);
  cell_.advance(kFewFrames);
  EXPECT_EQ(seen(part_), nullptr);
  EXPECT_NE(seen("part_medium_gear_2"), nullptr);
  cell_.end(id);
  cell_.advance(kFewFrames);
  EXPECT_NE(seen(part_), nullptr);
}

TEST_F(CameraFault, AGhostIsSeenBesideTheRealOne) {
  const auto id =
      cell_.inject("camera-ghost", "fanuc:" + part_, {{"x", 0.3}, {"y", -0.2}, {"yaw", 1}});
  cell_.advance(kFewFrames);
  const auto count = [&] {
    return std::ranges::count(frame().detections, static_cast<int>(cell_.body(part_)),
                              &api::VisionDetection::body);
  };
  EXPECT_EQ(count(), 2);
  EXPECT_EQ(seen(part_)->x_m, 0.3);
  EXPECT_EQ(seen(part_)->y_m, -0.2);
  cell_.end(id);
  cell_.advance(kFewFrames);
  EXPECT_EQ(count(), 1);
}

TEST_F(CameraFault, ABiasMovesAndTurnsAll) {
  cell_.advance(kFewFrames);
  const double yaw = seen("kit_m2l1_vessel_1")->rotation_rad;
  const auto id = cell_.inject("camera-bias", "fanuc", {{"x", 0.02}, {"y", -0.01}, {"yaw", 0.1}});
  cell_.advance(kFewFrames);
  EXPECT_NEAR(off(part_), std::hypot(0.02, 0.01), 2e-3);
  EXPECT_NEAR(seen("kit_m2l1_vessel_1")->rotation_rad - yaw, 0.1, 0.02);
  cell_.end(id);
  cell_.advance(kFewFrames);
  EXPECT_LT(off(part_), 2e-3);
}

TEST_F(CameraFault, AScaleGrowsWithTheDistance) {
  const auto id = cell_.inject("camera-scale", "fanuc", {{"factor", 1.1}});
  cell_.advance(kFewFrames);
  EXPECT_NEAR(off(part_), 0.1 * true_xy(part_).norm(), 2e-3);
  cell_.end(id);
  cell_.advance(kFewFrames);
  EXPECT_LT(off(part_), 2e-3);
}

TEST_F(CameraFault, SwappedLabelsChangePlaces) {
  const std::string large = "part_large_gear_1";
  const Eigen::Vector2d medium_at = true_xy(part_), large_at = true_xy(large);
  const auto id = cell_.inject("camera-swaps-labels", part_ + ":" + large);
  cell_.advance(kFewFrames);
  const auto at = [&](const std::string& body) {
    return Eigen::Vector2d(seen(body)->x_m, seen(body)->y_m);
  };
  EXPECT_LT((at(large) - medium_at).norm(), 2e-3);
  EXPECT_LT((at(part_) - large_at).norm(), 2e-3);
  cell_.end(id);
  cell_.advance(kFewFrames);
  EXPECT_LT(off(part_), 2e-3);
}

TEST_F(CameraFault, KitTraysFlipBetweenFrames) {
  const auto flips = [&] {
    int count = 0;
    double before = seen("kit_m2l1_vessel_1")->rotation_rad;
    for (int i = 0; i < 4000; ++i) {
      cell_.advance();
      const double now = seen("kit_m2l1_vessel_1")->rotation_rad;
      count += std::abs(std::remainder(now - before, 2 * std::numbers::pi)) > 3 ? 1 : 0;
      before = now;
    }
    return count;
  };
  cell_.advance(kFewFrames);
  EXPECT_EQ(flips(), 0);
  const auto id = cell_.inject("camera-flips-trays", "fanuc", {{"rate", 0.5}});
  EXPECT_GT(flips(), 8) << "of 40 frames";
  EXPECT_LT(off("kit_m2l1_vessel_1"), 2e-3);
  cell_.end(id);
  cell_.advance(kFewFrames);
  EXPECT_EQ(flips(), 0);
}

TEST_F(CameraFault, AFaultyPartHasALowScore) {
  cell_.advance(kFewFrames);
  const double before = seen(part_)->score;
  const auto id = cell_.inject("part-faulty", part_, {{"score", 0.3}});
  cell_.advance(kFewFrames);
  EXPECT_NEAR(seen(part_)->score, 0.3 * before, 1e-9);
  EXPECT_EQ(seen("part_medium_gear_2")->score, before);
  cell_.end(id);
  cell_.advance(kFewFrames);
  EXPECT_EQ(seen(part_)->score, before);
}

TEST_F(CameraFault, AForeignObjectHidesWhatIsUnderIt) {
  cell_.advance(kFewFrames);
  ASSERT_NE(seen(part_), nullptr);
  const Eigen::Vector3d at = cell_.X_WB(part_).translation();
  const auto id = cell_.inject("foreign-object", "",
                               {{"x", at.x()},
                                {"y", at.y()},
                                {"z", at.z() + 0.05},
                                {"width", 0.2},
                                {"depth", 0.2},
                                {"height", 0.05}});
  cell_.advance(kFewFrames);
  EXPECT_EQ(seen(part_), nullptr);
  ASSERT_TRUE(cell_.now.intruder);
  cell_.end(id);
  cell_.advance(kFewFrames);
  EXPECT_NE(seen(part_), nullptr);
  EXPECT_FALSE(cell_.now.intruder);
}

// ---- the light curtain

TEST(CurtainFault, APersonBreaksItForAWhile) {
  FaultCell cell;
  cell.advance(20);
  ASSERT_FALSE(cell.now.light_curtain.broken);
  cell.inject("curtain-broken", "", {}, SimTime(500ms));
  cell.advance(20);
  EXPECT_TRUE(cell.now.light_curtain.broken);
  EXPECT_TRUE(cell.now.intruder);
  cell.advance(500);
  EXPECT_FALSE(cell.now.light_curtain.broken);
  EXPECT_FALSE(cell.now.intruder);
}

TEST(CurtainFault, WhoeverElseIsThereStays) {
  FaultCell cell;
  api::Intruder somebody;
  somebody.X_WI.p = {0, -1.75, 0.9};
  somebody.size_m = {0.5, 0.3, 1.8};
  cell.world.apply(1, api::SetIntruder{somebody});
  cell.inject("curtain-broken", "", {}, SimTime(200ms));
  cell.advance(300);
  EXPECT_TRUE(cell.now.light_curtain.broken);
  EXPECT_EQ(cell.now.intruder->X_WI.p.x(), 0);
}

// ---- triggers in the real cell

TEST(FaultTriggers, ThePlacedGearOfAType) {
  FaultCell cell;
  const auto other =
      cell.inject("belt-slip", "", {}, {}, api::WhenPlaced{"sku_part_small_gear", ""});
  const auto id =
      cell.inject("belt-jam", "", {}, {}, api::WhenPlaced{"sku_part_large_gear", "fanuc"});
  const auto grasped = cell.inject("belt-wrong-speed", "", {}, {}, api::WhenGrasped{"fanuc", 1});
  const auto force =
      cell.inject("camera-outage", "fanuc", {}, {},
                  api::WhenCrossing{faults::Quantity::kGripForce, "fanuc", 1, true, 1.0});
  pick_and_place(cell, kFanucArm, "part_large_gear_1", "kit_m2l1_vessel_1", "lg_1", 0);
  EXPECT_EQ(cell.fault(id).state, api::FaultState::kActive);
  EXPECT_EQ(cell.fault(grasped).state, api::FaultState::kActive);
  EXPECT_EQ(cell.fault(force).state, api::FaultState::kActive);
  EXPECT_LT(*cell.fault(force).begin_step, *cell.fault(id).begin_step);
  EXPECT_LT(*cell.fault(grasped).begin_step, *cell.fault(id).begin_step);
  EXPECT_EQ(cell.fault(other).state, api::FaultState::kPending);
}

TEST(FaultTriggers, ValuesThatCrossALimit) {
  FaultCell cell;
  cell.act(kFanucArm, api::InitRobot{});
  const double q = cell.robot(kFanucArm).joints[0].position_rad;
  const double z = cell.robot(kFanucArm).X_WT.p.z();
  using faults::Quantity;
  const auto joint =
      cell.inject("belt-jam", "", {}, {},
                  api::WhenCrossing{Quantity::kJointPosition, "fanuc", 1, true, q + 0.1});
  const auto height = cell.inject(
      "belt-jam", "", {}, {}, api::WhenCrossing{Quantity::kToolHeight, "fanuc", 1, false, z - 0.1});
  const auto travel = cell.inject("belt-slip", "", {}, {},
                                  api::WhenCrossing{Quantity::kBeltTravel, "", 1, true, 0.01});
  const auto speed = cell.inject("belt-slip", "", {}, {},
                                 api::WhenCrossing{Quantity::kBeltSpeed, "", 1, true, 0.05});
  const double closed = cell.description(kFanucArm).gripper.gap_closed_m;
  const auto gap =
      cell.inject("belt-slip", "", {}, {},
                  api::WhenCrossing{Quantity::kSeparation, "fanuc", 1, false, closed + 1e-3});
  const auto event = cell.inject("belt-slip", "", {}, {}, api::WhenReported{"order-submitted"});
  cell.run_belt(0.1);
  cell.advance(500);
  EXPECT_EQ(cell.fault(travel).state, api::FaultState::kActive);
  EXPECT_EQ(cell.fault(speed).state, api::FaultState::kActive);
  EXPECT_EQ(cell.fault(joint).state, api::FaultState::kPending);
  cell.act(kFanucArm, turn(0, q + 0.2));
  EXPECT_EQ(cell.fault(joint).state, api::FaultState::kActive);
  EXPECT_EQ(cell.fault(height).state, api::FaultState::kPending);
  EXPECT_EQ(cell.fault(event).state, api::FaultState::kPending);
  ASSERT_TRUE(cell.world.apply(77, api::FaultCommand(api::ReportEvent{"order-submitted"})));
  cell.advance();
  EXPECT_EQ(cell.fault(event).state, api::FaultState::kActive);
  EXPECT_EQ(cell.fault(gap).state, api::FaultState::kPending);
  cell.act(kFanucArm, api::SetGripper{0});
  EXPECT_EQ(cell.fault(gap).state, api::FaultState::kActive);
}

TEST(FaultTriggers, ABrokenBeam) {
  FaultCell cell;
  const auto id = cell.inject("belt-jam", "", {}, {}, api::WhenBeamBroken{"downstream"});
  cell.advance(20);
  EXPECT_EQ(cell.fault(id).state, api::FaultState::kPending);
  cell.inject("photo-eye-stuck-on", "downstream");
  cell.advance(20);
  EXPECT_EQ(cell.fault(id).state, api::FaultState::kActive) << "as the eye says";
}

}  // namespace
}  // namespace aprsim::test
