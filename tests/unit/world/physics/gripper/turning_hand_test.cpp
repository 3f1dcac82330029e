// Invariant of a grasp: a part within the friction limit keeps its place in a hand that turns,
// about any axis, at any rate, by fingers of either shape and by a cup, in every mode.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "tests/unit/world/physics/cell_builder.hpp"

namespace aprsim::physics::test {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kStep = 1e-3;

/// Quintic from 0 to 1 with rest at both ends.
double smooth(double share) { return share * share * share * (10 + share * (6 * share - 15)); }

/// Turns the hand by `angle` about an axis through a point of the tool frame, at most at `rate`.
void turn(Bench& bench, const Vector3d& axis_T, const Vector3d& point_T, double angle,
          double rate) {
  const Isometry3d start = bench.X_WT;
  const int steps = static_cast<int>(1.875 * std::abs(angle) / rate / kStep);
  for (int i = 1; i <= steps; ++i) {
    const Isometry3d turned = start * Eigen::Translation3d(point_T) *
                              AngleAxisd(angle * smooth(double(i) / steps), axis_T) *
                              Eigen::Translation3d(-point_T);
    bench.step_tool(turned);
  }
}

struct Drift {
  double m = 0, rad = 0;
};

Drift drift_of(const Isometry3d& before, const Isometry3d& after) {
  return {(before.inverse() * after).translation().norm(), angle_between(before, after)};
}

/// A gear in the fingers, lifted off the stand that it stood on.
Bench gear_in_hand(scene::PadShape pad, scene::Simplification mode) {
  scene::Scene scene = empty_scene();
  scene.physics.simplification = mode;
  add_hand(scene, {0, 0, 1}).gripper.pad = pad;
  Pose gear;
  gear.p = {0, 0, 1 - 0.0095};
  add_gear(scene, "g", "medium", gear);
  Pose stand;
  stand.p = {0, 0, gear.p.z() - 0.012 - 0.025};
  scene.fixed.push_back({"stand", {0.2, 0.2, 0.05}, stand});
  Bench bench(std::move(scene));
  bench.run(50);
  bench.grip(0);
  bench.run(100);
  bench.move({0, 0, 0.25}, 0.5);
  bench.run(200);
  return bench;
}

/// A disc or a tray under a cup, lifted off the stand that it lay on.
Bench part_under_cup(bool tray, scene::Simplification mode, std::mt19937& random) {
  std::uniform_real_distribution<> radius(0.02, 0.05), height(0.005, 0.02), mass(0.01, 0.08);
  constexpr double kCupOverPart = 5e-4;
  scene::Scene scene = empty_scene();
  scene.physics.simplification = mode;
  double top_m = 0;
  if (tray) {
    add_tray(scene, "g", "small4", {0, 0}, {});
    top_m = scene.tray_types.at("small4").thickness_m;
  } else {
    scene::GearType disc;
    disc.name = "disc";
    disc.disc_radius_m = radius(random);
    disc.disc_height_m = disc.peg_top_m = top_m = height(random);
    disc.mass_kg = mass(random);
    scene.gear_types["disc"] = disc;
    add_gear(scene, "g", "disc", {});
  }
  Pose stand;
  stand.p.z() = -0.025;
  scene.fixed.push_back({"stand", {0.2, 0.2, 0.05}, stand});
  add_hand(scene, {0, 0, top_m + kCupOverPart}).gripper.cup =
      scene::VacuumCup{.radius_m = 0.012,
                       .max_vacuum_pa = 60e3,
                       .free_flow_m3_s = 1e-3,
                       .evacuation_s = 0.03,
                       .lip_compliance_m = 2e-3,
                       .roughness_m = 5e-6};
  Bench bench(std::move(scene));
  bench.run(50);
  bench.move({0, 0, -1.6 * kCupOverPart}, 0.1);
  bench.grip(0);
  bench.run(400);
  bench.move({0, 0, 0.5}, 1);
  bench.run(200);
  return bench;
}

class TurningHand : public ::testing::TestWithParam<scene::Simplification> {};

std::string mode_name(const ::testing::TestParamInfo<scene::Simplification>& info) {
  switch (info.param) {
    case scene::Simplification::kOff:
      return "off";
    case scene::Simplification::kMerge:
      return "merge";
    case scene::Simplification::kDormant:
      return "dormant";
    case scene::Simplification::kVirtualJoints:
      return "virtual_joints";
  }
  return "?";
}

/// There and back, so that gravity deflects the hand as before.
TEST_P(TurningHand, KeepsAGearInItsPlace) {
  std::mt19937 random(17);
  std::uniform_real_distribution<> any(-1, 1), rate(0.5, 6), angle(0.5, std::numbers::pi);
  for (const auto pad : {scene::PadShape::kFlat, scene::PadShape::kV}) {
    Bench bench = gear_in_hand(pad, GetParam());
    ASSERT_TRUE(bench.world->gripper(0).holding);
    const Isometry3d before = bench.X_TB("g");
    for (int round = 0; round < 10; ++round) {
      const Vector3d axis = Vector3d(any(random), any(random), any(random)).normalized();
      const Vector3d point = 0.1 * Vector3d(any(random), any(random), any(random));
      const double by = angle(random), at = rate(random);
      turn(bench, axis, point, by, at);
      turn(bench, axis, point, -by, at);
    }
    bench.run(200);
    const Drift drift = drift_of(before, bench.X_TB("g"));
    EXPECT_TRUE(bench.world->gripper(0).holding);
    // Between V pads a part is wedged, and settles within the pads' compliance in the first turns.
    const bool wedged = pad == scene::PadShape::kV;
    EXPECT_LT(drift.m, wedged ? 3e-7 : 1e-9) << (wedged ? "V pads" : "flat pads");
    EXPECT_LT(drift.rad, wedged ? 1e-4 : 1e-7) << (wedged ? "V pads" : "flat pads");
  }
}

TEST_P(TurningHand, KeepsAPartOnACup) {
  std::mt19937 random(18);
  std::uniform_real_distribution<> any(-1, 1), rate(0.5, 5), angle(0.5, std::numbers::pi);
  for (const bool tray : {false, false, true}) {
    Bench bench = part_under_cup(tray, GetParam(), random);
    ASSERT_TRUE(bench.world->gripper(0).holding);
    const Isometry3d before = bench.X_TB("g");
    double farthest = 0;
    for (int round = 0; round < 10; ++round) {
      const Vector3d axis = Vector3d(any(random), any(random), any(random)).normalized();
      const Vector3d point = 0.05 * Vector3d(any(random), any(random), any(random));
      const double by = angle(random), at = rate(random);
      turn(bench, axis, point, by, at);
      farthest = std::max(farthest, drift_of(before, bench.X_TB("g")).m);
      turn(bench, axis, point, -by, at);
    }
    bench.run(200);
    const Drift drift = drift_of(before, bench.X_TB("g"));
    EXPECT_TRUE(bench.world->gripper(0).holding);
    EXPECT_LT(farthest, 1e-5) << (tray ? "tray" : "disc");
    EXPECT_LT(drift.m, 1e-9) << (tray ? "tray" : "disc");
    EXPECT_LT(drift.rad, 1e-7) << (tray ? "tray" : "disc");
  }
}

INSTANTIATE_TEST_SUITE_P(Modes, TurningHand,
                         ::testing::Values(scene::Simplification::kOff,
                                           scene::Simplification::kMerge,
                                           scene::Simplification::kDormant),
                         mode_name);

}  // namespace
}  // namespace aprsim::physics::test
