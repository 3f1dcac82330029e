// Camera and light curtain see the same, whichever way contacts are simplified.

#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/cell_script.hpp"
#include "tests/support/parameter_names.hpp"

namespace aprsim::test {
namespace {

using scene::Simplification;

constexpr std::size_t kBeams = 4;
constexpr std::size_t kCamera = 1;  // the Motoman's, over the belt
constexpr const char* kSensedTray = "small_gear_vessel_2";

/// The default cell with a camera that sees more of the belt and a curtain across the belt,
/// upstream of that: beams through the trays, through the gears' discs, through their pegs and
/// above all.
CellScript cell(Simplification mode) {
  scene::Scene scene = *load_scene("aprs");
  scene.physics.simplification = mode;
  scene.robots[kCamera].vision.area_min.y() = -0.65;  // along the belt, upstream
  api::LightCurtainDescription& curtain = *scene.light_curtain;
  curtain.X_WK.p = {-0.75, -0.85, 0.919};
  curtain.X_WK.q = Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ());
  curtain.beams = kBeams;
  curtain.pitch_m = 0.012;
  curtain.range_m = 0.7;
  return CellScript(std::make_shared<const scene::Scene>(std::move(scene)));
}

std::array<bool, kBeams> broken_beams(const api::Snapshot& now) {
  std::array<bool, kBeams> out;
  for (std::size_t i = 0; i < kBeams; ++i) out[i] = now.light_curtain.distance_m[i] < 0.7;
  return out;
}

bool sees(const api::VisionFrame& frame, std::size_t body) {
  return std::any_of(frame.detections.begin(), frame.detections.end(), [&](const auto& detection) {
    return detection.body == static_cast<int>(body);
  });
}

void expect_same(const api::VisionFrame& one, const api::VisionFrame& other) {
  ASSERT_EQ(one.number, other.number);
  ASSERT_EQ(one.time, other.time);
  ASSERT_EQ(one.detections.size(), other.detections.size());
  for (std::size_t i = 0; i < one.detections.size(); ++i) {
    const auto& a = one.detections[i];
    const auto& b = other.detections[i];
    ASSERT_EQ(a.body, b.body);
    ASSERT_LT(std::hypot(a.x_m - b.x_m, a.y_m - b.y_m), 1e-5) << "body " << a.body;
    ASSERT_LT(std::abs(std::remainder(a.rotation_rad - b.rotation_rad, 2 * M_PI)), 1e-4)
        << "body " << a.body;
    ASSERT_NEAR(a.score, b.score, 1e-9) << "body " << a.body;
  }
}

class SensorsByMode : public testing::TestWithParam<Simplification> {};

// The belt takes a tray with gears through the curtain and before the camera, and stops.
TEST_P(SensorsByMode, SeeTheSame) {
  CellScript full = cell(Simplification::kOff), simplified = cell(GetParam());
  const std::size_t tray = full.body(kSensedTray);
  const bool at_start = sees(full.now.robots[kCamera].vision, tray);
  const auto expected =
      GetParam() == Simplification::kMerge ? api::GroupKind::kMerged : api::GroupKind::kDormant;
  std::array<int, kBeams> changes{};
  int steps_in_group = 0;
  for (int step = 0; step < 2600; ++step) {
    const auto before = broken_beams(full.now);
    for (CellScript* each : {&full, &simplified}) {
      const bool run = step >= 300 && step < 2000;
      if (step == 300 || step == 2000) {
        each->world.apply(1 + static_cast<api::Ticket>(step),
                          api::ConveyorCommand{.run = run, .forward = true, .speed_m_s = 0.3});
      }
      each->advance();
    }
    ASSERT_NO_FATAL_FAILURE(
        expect_same(full.now.robots[kCamera].vision, simplified.now.robots[kCamera].vision))
        << "step " << step;
    const auto beams = broken_beams(full.now);
    ASSERT_EQ(beams, broken_beams(simplified.now)) << "step " << step;
    ASSERT_EQ(full.now.light_curtain.broken, simplified.now.light_curtain.broken);
    for (std::size_t i = 0; i < kBeams; ++i) changes[i] += beams[i] != before[i] ? 1 : 0;
    ASSERT_EQ(full.now.bodies[tray].group_kind, api::GroupKind::kNone);
    if (simplified.now.bodies[tray].group_kind == expected) ++steps_in_group;
  }
  EXPECT_FALSE(at_start);
  EXPECT_TRUE(sees(full.now.robots[kCamera].vision, tray));
  EXPECT_GT(full.now.robots[kCamera].vision.number, 20U);
  EXPECT_EQ(full.now.conveyor.speed_m_s, 0);
  for (std::size_t i = 0; i + 1 < kBeams; ++i) EXPECT_GE(changes[i], 2) << "beam " << i;
  EXPECT_EQ(changes[kBeams - 1], 0) << "above all";
  EXPECT_GT(steps_in_group, 1500);
}

INSTANTIATE_TEST_SUITE_P(Simplification, SensorsByMode,
                         testing::Values(Simplification::kMerge, Simplification::kDormant),
                         [](const auto& mode) {
                           return mode.param == Simplification::kMerge ? "merge" : "dormant";
                         });

}  // namespace
}  // namespace aprsim::test
