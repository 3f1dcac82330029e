#include "world/sensors/overhead_camera.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include <gtest/gtest.h>

namespace aprsim::sensors {
namespace {

constexpr double kPi = std::numbers::pi;

scene::FreeBody gear() {
  scene::FreeBody body;
  body.type = "gear";
  body.disc_radius_m = 0.04;
  body.disc_height_m = 0.015;
  body.peg_top_m = 0.03;
  return body;
}

scene::FreeBody tray() {
  scene::FreeBody body;
  body.type = "tray";
  body.kind = api::BodyKind::kPartTray;
  body.slab = Eigen::AlignedBox3d(Eigen::Vector3d(-0.1, -0.1, -0.02), Eigen::Vector3d(0.1, 0.1, 0));
  return body;
}

Eigen::Isometry3d standing(double x, double y, double yaw = 0) {
  return Eigen::Translation3d(x, y, 0) * Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ());
}

class OverheadCameraTest : public testing::Test {
 protected:
  OverheadCameraTest() {
    vision.position_noise_m = 0;
    vision.rotation_noise_rad = 0;
  }
  void add(const scene::FreeBody& body, const Eigen::Isometry3d& X_WP) {
    bodies.push_back(body);
    poses.push_back(X_WP);
  }
  void hide_behind(const Shape& shape, const Eigen::Vector3d& p_W) {
    Occluder occluder{.shape = shape, .bound_m = bounding_radius(shape)};
    occluder.X_WS.translation() = p_W;
    occluders.push_back(occluder);
  }
  std::vector<api::VisionDetection> look(std::uint64_t seed = 1) {
    api::VisionFrame frame;
    frame.detections.resize(3);  // of an earlier frame
    OverheadCamera(vision, X_WR).detect(bodies, poses, occluders, seed, frame);
    return frame.detections;
  }

  scene::Vision vision;
  Eigen::Isometry3d X_WR = Eigen::Isometry3d::Identity();
  std::vector<scene::FreeBody> bodies;
  std::vector<Eigen::Isometry3d> poses;
  std::vector<Occluder> occluders;
};

// A part is reported by its frame, without the mistakes that trays and gears have.
TEST_F(OverheadCameraTest, ReportsPartsByTheirFrames) {
  scene::FreeBody part;
  part.type = "pump";
  part.kind = api::BodyKind::kPart;
  part.pieces = {{api::BoxPiece{{0.1, 0.05, 0.04}}, {}}};
  part.slab = Eigen::AlignedBox3d(Eigen::Vector3d(-0.05, -0.025, -0.02),
                                  Eigen::Vector3d(0.05, 0.025, 0.02));
  vision.gear_yaw_rad = 1;
  vision.part_tray_flip_rate = vision.kit_tray_flip_rate = 1;
  vision.tray_yaw_offset_rad = 0.5;
  add(part, standing(0.4, 0.1, 0.3));
  const auto seen = look();
  ASSERT_EQ(seen.size(), 1U);
  EXPECT_NEAR(seen[0].x_m, 0.4, 1e-12);
  EXPECT_NEAR(seen[0].rotation_rad, 0.3, 1e-12);
  EXPECT_EQ(seen[0].score, 1);
}

// A part under the top face is seen through the mouth of its pocket, not through the slab.
TEST_F(OverheadCameraTest, SeesAPartInAnOutlinedPocket) {
  scene::FreeBody nut;
  nut.type = "nut";
  nut.kind = api::BodyKind::kPart;
  nut.slab = Eigen::AlignedBox3d(Eigen::Vector3d(-0.007, -0.007, -0.003),
                                 Eigen::Vector3d(0.007, 0.007, 0.003));
  scene::Slot slot;
  slot.xy = {0.05, 0};
  slot.yaw_rad = 0.5;
  slot.pocket.depth_m = 0.01;
  slot.pocket.outline =
      scene::outline_of({{-0.008, -0.008}, {0.008, -0.008}, {0.008, 0.008}, {-0.008, 0.008}});
  for (const bool has_pocket : {true, false}) {
    for (const double off : {0.0, 0.02}) {
      bodies.clear();
      poses.clear();
      occluders.clear();
      scene::FreeBody board = tray();
      if (has_pocket) board.outlined = {slot};
      add(board, standing(0.4, 0.1));
      add(nut, standing(0.45 + off, 0.1, 0.5) * Eigen::Translation3d(0, 0, -0.006));
      hide_behind(robot::BoxShape{{0.2, 0.2, 0.02}}, {0.4, 0.1, -0.01});
      occluders.back().body = 0;
      const auto seen = look();
      const bool part_seen =
          std::ranges::any_of(seen, [](const auto& object) { return object.body == 1; });
      EXPECT_EQ(part_seen, has_pocket && off == 0) << has_pocket << off;
    }
  }
}

TEST_F(OverheadCameraTest, GivesPosesInTheVisionFrame) {
  X_WR = Eigen::Translation3d(1, 2, 0.9) * Eigen::AngleAxisd(kPi / 2, Eigen::Vector3d::UnitZ());
  vision.X_RV.p = {0.1, 0, 0};
  add(gear(), standing(1, 2.5, 0.75 * kPi));
  const auto seen = look();
  ASSERT_EQ(seen.size(), 1U);
  EXPECT_EQ(seen[0].body, 0);
  EXPECT_NEAR(seen[0].x_m, 0.4, 1e-12);
  EXPECT_NEAR(seen[0].y_m, 0, 1e-12);
  EXPECT_NEAR(seen[0].rotation_rad, 0.25 * kPi, 1e-12);
  EXPECT_EQ(seen[0].score, 1);
}

TEST_F(OverheadCameraTest, WrapsAnglesIntoOneTurn) {
  for (const double yaw : {-3.0, -1.0, 0.0, 2.0, 3.0, 3.5, 5.0}) {
    bodies.clear();
    poses.clear();
    add(tray(), standing(0, 0, yaw));
    vision.rotation_noise_rad = 0.3;  // noise must not lead out of the range either
    for (std::uint64_t seed = 0; seed < 50; ++seed) {
      const double angle = look(seed).at(0).rotation_rad;
      EXPECT_GT(angle, -kPi);
      EXPECT_LE(angle, kPi);
      EXPECT_LE(std::abs(std::remainder(angle - yaw, 2 * kPi)), 3.5 * 0.3 + 1e-12);
    }
  }
}

TEST_F(OverheadCameraTest, IsOffByWhatItsCalibrationSays) {
  // Stretched, shifted, and turned by about 30 mrad.
  vision.image << 0.01, 1.02, -0.03, 0, -0.005, 0.03, 1.02, 0;
  add(gear(), standing(0.5, 0.2, 0.4));
  add(tray(), standing(-0.2, 0.1, -1));
  auto seen = look();
  ASSERT_EQ(seen.size(), 2U);
  EXPECT_NEAR(seen[0].x_m, 0.01 + 1.02 * 0.5 - 0.03 * 0.2, 1e-12);
  EXPECT_NEAR(seen[0].y_m, -0.005 + 0.03 * 0.5 + 1.02 * 0.2, 1e-12);
  const double turn = std::atan2(0.03, 1.02);
  EXPECT_NEAR(seen[0].rotation_rad, 0.4 + turn, 1e-12);
  EXPECT_NEAR(seen[1].rotation_rad, -1 + turn, 1e-12);
  // Bilinear: the farther out in x, the more y counts.
  vision.image = scene::Vision{}.image;
  vision.image(0, 3) = 0.1;
  seen = look();
  EXPECT_NEAR(seen[0].x_m, 0.5 + 0.1 * 0.5 * 0.2, 1e-12);
  EXPECT_NEAR(seen[0].y_m, 0.2, 1e-12);
}

TEST_F(OverheadCameraTest, TakesGearsForTurnedAnyhow) {
  vision.gear_yaw_rad = 0.8;
  for (int i = 0; i < 5; ++i) add(gear(), standing(0.2 * i, 0, 2));
  add(tray(), standing(0, 0.5, 2));
  double lowest = 1, highest = -1, sum = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const auto seen = look(seed);
    ASSERT_EQ(seen.size(), 6U);
    for (int i = 0; i < 5; ++i) {
      const double yaw = seen[static_cast<std::size_t>(i)].rotation_rad;
      lowest = std::min(lowest, yaw);
      highest = std::max(highest, yaw);
      sum += yaw;
    }
    EXPECT_NEAR(seen[5].rotation_rad, 2, 1e-12) << "trays have an angle";
  }
  EXPECT_GE(lowest, -0.8);
  EXPECT_LE(highest, 0.8);
  EXPECT_LT(lowest, -0.75);
  EXPECT_GT(highest, 0.75);
  // Uniform: the mean of 500 has a standard deviation of 0.8 / sqrt(3 * 500).
  EXPECT_LT(std::abs(sum / 500), 4 * 0.8 / std::sqrt(1500));
  vision.gear_yaw_rad = 0;
  EXPECT_EQ(look()[0].rotation_rad, 0);
}

TEST_F(OverheadCameraTest, CountsTheYawOfTraysFromAZeroOfItsOwn) {
  vision.tray_yaw_offset_rad = -kPi / 2;
  add(tray(), standing(0, 0, 0.3));
  add(gear(), standing(0.5, 0, 0.3));
  const auto seen = look();
  ASSERT_EQ(seen.size(), 2U);
  EXPECT_NEAR(seen[0].rotation_rad, 0.3 - kPi / 2, 1e-12);
  EXPECT_NEAR(seen[1].rotation_rad, 0.3, 1e-12);
}

TEST_F(OverheadCameraTest, TakesTraysForTurnedAsTheyLookAlike) {
  vision.part_tray_flip_rate = 0.25;
  vision.kit_tray_flip_rate = 0.5;
  auto oblong = tray(), kit = tray();
  oblong.slab.max().x() = 0.2;
  kit.slab.max().x() = 0.2;
  kit.kind = api::BodyKind::kKitTray;
  add(tray(), standing(0, 0, 0.3));
  add(oblong, standing(0.5, 0, 0.3));
  add(kit, standing(0, 0.5, 0.3));
  add(gear(), standing(0.5, 0.5, 0.3));
  const double step[] = {kPi / 2, kPi, kPi};
  int turned[3] = {0, 0, 0};
  constexpr int kFrames = 1000;
  for (std::uint64_t seed = 0; seed < kFrames; ++seed) {
    const auto seen = look(seed);
    ASSERT_EQ(seen.size(), 4U);
    for (std::size_t i = 0; i < 3; ++i) {
      const double by = std::remainder(seen[i].rotation_rad - 0.3, 2 * kPi);
      if (std::abs(by) < 1e-9) continue;
      EXPECT_NEAR(std::abs(by), step[i], 1e-9);
      ++turned[i];
    }
    EXPECT_NEAR(seen[3].rotation_rad, 0.3, 1e-12);
  }
  // Within five standard deviations.
  EXPECT_NEAR(turned[0], 250, 70);
  EXPECT_NEAR(turned[1], 250, 70);
  EXPECT_NEAR(turned[2], 500, 80);
}

TEST_F(OverheadCameraTest, SeesOnlyItsArea) {
  vision.area_min = {-0.2, -0.1};
  vision.area_max = {0.2, 0.1};
  for (const double x : {-0.21, -0.19, 0.19, 0.21}) add(gear(), standing(x, 0));
  for (const double y : {-0.11, -0.09, 0.09, 0.11}) add(gear(), standing(0, y));
  std::set<int> numbers;
  for (const auto& seen : look()) numbers.insert(seen.body);
  EXPECT_EQ(numbers, (std::set<int>{1, 2, 5, 6}));
}

TEST_F(OverheadCameraTest, PassesOverWhatHasFallenOver) {
  add(gear(), standing(0, 0) * Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitX()));
  add(gear(), standing(0.2, 0) * Eigen::AngleAxisd(0.6, Eigen::Vector3d::UnitX()));
  add(gear(), standing(0.4, 0) * Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX()));
  const auto seen = look();
  ASSERT_EQ(seen.size(), 1U);
  EXPECT_EQ(seen[0].body, 0);
}

TEST_F(OverheadCameraTest, ArmHidesPartsBehindIt) {
  add(gear(), standing(0, 0));
  add(gear(), standing(0.3, 0));
  hide_behind(robot::CapsuleShape{0.05, 0.2}, {0, 0, 1});
  auto seen = look();
  ASSERT_EQ(seen.size(), 1U) << "the arm hangs between the camera at 2 m and the first gear";
  EXPECT_EQ(seen[0].body, 1);
  EXPECT_EQ(seen[0].score, 1);
  vision.occlusion = false;
  EXPECT_EQ(look().size(), 2U) << "unless told to see through everything";
  vision.occlusion = true;
  vision.camera_V = {0.5, 0, 2};
  EXPECT_EQ(look().size(), 2U) << "seen from the side, past the arm";
}

TEST_F(OverheadCameraTest, PartHidesPartsBehindIt) {
  add(gear(), standing(0, 0));
  add(gear(), standing(0, 0) * Eigen::Translation3d(0, 0, 0.3));
  const robot::CylinderShape disc{0.04, 0.015};
  hide_behind(disc, {0, 0, 0.0075});
  occluders.back().body = 0;
  hide_behind(disc, {0, 0, 0.3075});
  occluders.back().body = 1;
  const auto seen = look();
  ASSERT_EQ(seen.size(), 1U) << "the upper gear hides the lower, and none itself";
  EXPECT_EQ(seen[0].body, 1);
  EXPECT_EQ(seen[0].score, 1);
}

TEST_F(OverheadCameraTest, AGearOnATrayDoesNotHideItButOneAboveDoes) {
  add(tray(), standing(0, 0));
  add(gear(), standing(0, 0));
  hide_behind(robot::CylinderShape{0.04, 0.015}, {0, 0, 0.0075});
  occluders.back().body = 1;
  EXPECT_EQ(look().size(), 2U) << "trays are recognised full";
  poses[1].translation().z() = 0.1;
  occluders.back().X_WS.translation().z() = 0.1075;
  const auto seen = look();
  ASSERT_EQ(seen.size(), 1U);
  EXPECT_EQ(seen[0].body, 1);
}

TEST_F(OverheadCameraTest, ATrayHeldOverAPartHidesIt) {
  add(gear(), standing(0, 0));
  add(tray(), standing(0, 0) * Eigen::Translation3d(0, 0, 0.2));
  hide_behind(robot::BoxShape{{0.2, 0.2, 0.02}}, {0, 0, 0.19});
  occluders.back().body = 1;
  const auto seen = look();
  ASSERT_EQ(seen.size(), 1U);
  EXPECT_EQ(seen[0].body, 1);
}

TEST_F(OverheadCameraTest, ScoreIsTheShareInSight) {
  add(tray(), standing(0, 0));
  hide_behind(robot::SphereShape{0.02}, {0.1, 0.1, 0.03});
  const auto seen = look();
  ASSERT_EQ(seen.size(), 1U) << "one corner hidden, the middle is not";
  EXPECT_DOUBLE_EQ(seen[0].score, 0.8);
}

TEST_F(OverheadCameraTest, NoiseHasItsSizeAndIsClipped) {
  vision.position_noise_m = 0.001;
  vision.rotation_noise_rad = 0.02;
  add(gear(), standing(0.1, -0.1, 0.5));
  double sum = 0, squares = 0, turn_squares = 0, largest = 0;
  constexpr int kFrames = 20000;
  for (int seed = 0; seed < kFrames; ++seed) {
    const auto seen = look(static_cast<std::uint64_t>(seed)).at(0);
    const double dx = seen.x_m - 0.1, dy = seen.y_m + 0.1, turn = seen.rotation_rad - 0.5;
    sum += dx + dy;
    squares += dx * dx + dy * dy;
    turn_squares += turn * turn;
    largest = std::max({largest, std::abs(dx), std::abs(dy)});
    EXPECT_LE(std::abs(turn), 3.5 * 0.02 + 1e-12);
  }
  EXPECT_NEAR(sum / (2 * kFrames), 0, 2e-5);
  EXPECT_NEAR(std::sqrt(squares / (2 * kFrames)), 0.001, 2e-5);
  EXPECT_NEAR(std::sqrt(turn_squares / kFrames), 0.02, 4e-4);
  EXPECT_LE(largest, 0.0035 + 1e-12);
  EXPECT_GT(largest, 0.003) << "of 40000 some are beyond 3 sigma";
}

TEST_F(OverheadCameraTest, DropsItsShare) {
  vision.drop_rate = 0.25;
  for (int i = 0; i < 10; ++i) add(gear(), standing(0.1 * i, 0));
  std::size_t seen = 0;
  for (std::uint64_t seed = 0; seed < 2000; ++seed) seen += look(seed).size();
  EXPECT_NEAR(static_cast<double>(seen) / 20000, 0.75, 0.015);
}

TEST_F(OverheadCameraTest, TheSameSeedGivesTheSameBits) {
  vision.position_noise_m = 0.001;
  vision.drop_rate = 0.3;
  vision.shuffle = true;
  for (int i = 0; i < 10; ++i) add(gear(), standing(0.1 * i, 0));
  const auto a = look(7), b = look(7), c = look(8);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].body, b[i].body);
    EXPECT_EQ(a[i].x_m, b[i].x_m);
    EXPECT_EQ(a[i].rotation_rad, b[i].rotation_rad);
  }
  EXPECT_NE(a.at(0).x_m, c.at(0).x_m);
}

TEST_F(OverheadCameraTest, NoiseOfAnObjectIsIndependentOfTheOthers) {
  vision.position_noise_m = 0.001;
  add(gear(), standing(0, 0));
  add(gear(), standing(0.3, 0));
  const double before = look().at(1).x_m;
  poses[0] = standing(5, 0);  // out of sight
  EXPECT_EQ(look().at(0).x_m, before);
}

TEST_F(OverheadCameraTest, ShufflingKeepsAllAndEveryOrderComesUp) {
  vision.shuffle = true;
  for (int i = 0; i < 3; ++i) add(gear(), standing(0.2 * i, 0));
  std::set<std::vector<int>> orders;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    std::vector<int> order;
    for (const auto& seen : look(seed)) order.push_back(seen.body);
    ASSERT_EQ(std::set<int>(order.begin(), order.end()).size(), 3U);
    orders.insert(order);
  }
  EXPECT_EQ(orders.size(), 6U);
}

}  // namespace
}  // namespace aprsim::sensors
