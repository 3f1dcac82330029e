// The air of a vacuum cup against closed forms, and the rays that feel for what is under its lip.

#include "world/physics/gripper/suction.hpp"

#include <array>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/support/gear_types.hpp"
#include "world/physics/collision/speculative/ray_gap.hpp"

namespace aprsim::physics::test {
namespace {

using Eigen::Vector3d;

constexpr double kNone = kNoHit;

scene::VacuumCup cup() {
  return {.radius_m = 0.01,
          .max_vacuum_pa = 60e3,
          .free_flow_m3_s = 2e-4,
          .evacuation_s = 0.02,
          .lip_compliance_m = 5e-4,
          .roughness_m = 0};
}
const double kSection = std::numbers::pi * 1e-4;

std::array<double, 32> gaps(std::size_t covered, double open_gap = kNone) {
  std::array<double, 32> all;
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i < covered ? 1e-4 : open_gap;
  return all;
}

TEST(Suction, HoldsWithTheVacuumOverItsSection) {
  const LipSeal seal = seal_of(cup(), gaps(32));
  EXPECT_DOUBLE_EQ(seal.covered, 1);
  EXPECT_EQ(seal.leak_m2, 0);
  EXPECT_NEAR(steady_vacuum(cup(), seal.leak_m2), 60e3, 1e-6);
  EXPECT_NEAR(suction_force(cup(), 60e3, seal.covered), 60e3 * kSection, 1e-9);
}

// A share u of the rim open in full leaks through u of the cup's section; ejector and orifice meet
// where Q (1 - p / p0) = 0.6 A sqrt(2 p / 1.2).
TEST(Suction, AnUncoveredShareLeaksTheVacuumAway) {
  double before = 60e3;
  for (const std::size_t open : {1u, 4u, 16u, 32u}) {
    const LipSeal seal = seal_of(cup(), gaps(32 - open));
    const double share = static_cast<double>(open) / 32;
    EXPECT_NEAR(seal.covered, 1 - share, 1e-12);
    EXPECT_NEAR(seal.leak_m2, share * kSection, 1e-12);
    const double p = steady_vacuum(cup(), seal.leak_m2);
    const double out = 2e-4 * (1 - p / 60e3);
    const double in = 0.6 * seal.leak_m2 * std::sqrt(2 * p / 1.2);
    EXPECT_NEAR(in, out, 1e-12);
    EXPECT_LT(p, before);
    before = p;
  }
  const LipSeal half = seal_of(cup(), gaps(16));
  EXPECT_LT(suction_force(cup(), steady_vacuum(cup(), half.leak_m2), half.covered),
            0.001 * 60e3 * kSection);
}

TEST(Suction, AGapBeyondTheLipsReachLeaksByItsHeight) {
  const LipSeal narrow = seal_of(cup(), gaps(0, 6e-4));
  EXPECT_NEAR(narrow.leak_m2, 2 * std::numbers::pi * 0.01 * 6e-4, 1e-12);
  EXPECT_EQ(narrow.covered, 0);
  const LipSeal followed = seal_of(cup(), gaps(0, 5e-4));
  EXPECT_EQ(followed.leak_m2, 0);
  const LipSeal wide = seal_of(cup(), gaps(0, 0.1));
  EXPECT_NEAR(wide.leak_m2, kSection, 1e-12);
}

TEST(Suction, BuildsUpAndGoesWithItsTimeConstant) {
  const LipSeal seal = seal_of(cup(), gaps(32));
  double p = 0;
  for (int i = 0; i < 20; ++i) p = advance_vacuum(cup(), true, seal, 1e-3, p);
  EXPECT_NEAR(p, 60e3 * (1 - std::exp(-1)), 1e-6);
  for (int i = 0; i < 40; ++i) p = advance_vacuum(cup(), false, seal, 1e-3, p);
  EXPECT_NEAR(p, 60e3 * (1 - std::exp(-1)) * std::exp(-2), 1e-6);
}

TEST(RayGap, MeetsDiscPegAndHubOfAGear) {
  const scene::GearType gear = gear_type("small");
  Eigen::Isometry3d X_WG = Eigen::Isometry3d::Identity();
  X_WG.linear() = Eigen::AngleAxisd(0.3, Vector3d::UnitX()).toRotationMatrix();
  X_WG.translation() = Vector3d(0.1, -0.2, 0.5);
  const auto from = [&](const Vector3d& p, const Vector3d& d) {
    return distance_to_gear(gear, X_WG, {X_WG * p, X_WG.linear() * d.normalized()});
  };
  const Vector3d down = -Vector3d::UnitZ();
  EXPECT_NEAR(from({0.5 * gear.peg_radius_m, 0, gear.peg_top_m + 0.01}, down), 0.01, 1e-12);
  const double on_disc = 0.5 * (gear.peg_radius_m + gear.disc_radius_m);
  EXPECT_NEAR(from({0, on_disc, gear.disc_height_m + 0.02}, down), 0.02, 1e-12);
  EXPECT_EQ(from({gear.disc_radius_m + 1e-6, 0, 0.1}, down), kNone);
  EXPECT_NEAR(from({gear.disc_radius_m + 0.03, 0, 0.5 * gear.disc_height_m}, -Vector3d::UnitX()),
              0.03, 1e-12);
  EXPECT_EQ(from({0, 0, 0.5 * gear.disc_height_m}, down), 0) << "inside";
  EXPECT_EQ(from({0, 0, gear.peg_top_m + 0.01}, -down), kNone) << "behind";
  const double middle = -0.5 * gear.hub_height_m;
  const double hub = 0.5 * (gear.hub_top_radius_m + gear.hub_bottom_radius_m);
  EXPECT_NEAR(from({hub + 0.03, 0, middle}, -Vector3d::UnitX()), 0.03, 1e-3);
}

TEST(RayGap, FallsIntoATraysPockets) {
  scene::TrayType tray;
  tray.min_xy = {-0.1, -0.1};
  tray.max_xy = {0.1, 0.1};
  tray.thickness_m = 0.02;
  scene::Slot slot;
  slot.xy = {0.03, 0};
  slot.pocket = {.top_radius_m = 0.02, .floor_radius_m = 0.015, .depth_m = 0.012};
  tray.slots.push_back(slot);
  const Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  const auto down = [&](double x, double y) {
    return distance_to_tray(tray, X, {{x, y, 0.05}, -Vector3d::UnitZ()});
  };
  EXPECT_NEAR(down(-0.05, 0), 0.05, 1e-12);
  EXPECT_NEAR(down(0.03, 0.01), 0.062, 1e-12);
  EXPECT_NEAR(down(0.0501, 0), 0.05, 1e-12);
  EXPECT_EQ(down(0.11, 0), kNone);
}

TEST(RayGap, FallsIntoAPocketOfItsOutline) {
  scene::TrayType tray;
  tray.min_xy = {-0.1, -0.1};
  tray.max_xy = {0.1, 0.1};
  tray.thickness_m = 0.02;
  scene::Slot slot;
  slot.xy = {0.03, 0};
  slot.yaw_rad = std::numbers::pi / 2;
  slot.pocket.depth_m = 0.012;
  slot.pocket.chamfer_m = 0.001;
  slot.pocket.outline =
      scene::outline_of({{-0.02, -0.01}, {0.02, -0.01}, {0.02, 0.01}, {-0.02, 0.01}});
  tray.slots.push_back(slot);
  const auto down = [&](double x, double y) {
    return distance_to_tray(tray, Eigen::Isometry3d::Identity(),
                            {{x, y, 0.05}, -Vector3d::UnitZ()});
  };
  EXPECT_NEAR(down(0.03, 0.019), 0.062, 1e-12);
  EXPECT_NEAR(down(0.03, 0.0209), 0.062, 1e-12) << "in the chamfer";
  EXPECT_NEAR(down(0.03, 0.0211), 0.05, 1e-12);
  EXPECT_NEAR(down(0.045, 0), 0.05, 1e-12) << "beside it, as it is turned";
}

TEST(RayGap, PassesByTheCornerThatAnOutlineCutsOff) {
  scene::TrayType tray;
  tray.min_xy = {-0.1, -0.1};
  tray.max_xy = {0.1, 0.1};
  tray.thickness_m = 0.02;
  tray.outline = scene::outline_of({{-0.1, -0.1}, {0.1, -0.1}, {0.1, 0}, {0, 0.1}, {-0.1, 0.1}});
  const Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  const auto from = [&](const Vector3d& p, const Vector3d& d) {
    return distance_to_tray(tray, X, {p, d});
  };
  EXPECT_NEAR(from({0.049, 0.05, 0.05}, -Vector3d::UnitZ()), 0.05, 1e-12);
  EXPECT_EQ(from({0.051, 0.05, 0.05}, -Vector3d::UnitZ()), kNone);
  EXPECT_NEAR(from({0.2, 0.05, -0.01}, -Vector3d::UnitX()), 0.15, 1e-12) << "the slanted side";
  EXPECT_EQ(from({0.2, 0.05, 0.01}, -Vector3d::UnitX()), kNone) << "over it";
}

}  // namespace
}  // namespace aprsim::physics::test
