#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/world/physics/collision/solids.hpp"

namespace aprsim::physics {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kX = 0.045, kY = 0.045;  // slot of the tests

std::vector<Contact> contacts(const scene::GearType& g, const scene::TrayType& t,
                              const Isometry3d& X_PG, const Isometry3d& X_WP) {
  std::vector<Contact> out;
  gear_tray(g, X_WP * X_PG, t, X_WP, 3, 1, out);
  return out;
}

std::vector<Contact> contacts(const scene::GearType& g, const scene::TrayType& t,
                              const Isometry3d& X_PG) {
  return contacts(g, t, X_PG, Isometry3d::Identity());
}

struct Kind {
  scene::GearType gear;
  scene::TrayType tray;
};

class Seated : public testing::TestWithParam<bool> {
 protected:
  Kind kind() const {
    return GetParam() ? Kind{test::conical_gear(), test::conical_tray()}
                      : Kind{test::cylindrical_gear(), test::cylindrical_tray()};
  }
};
INSTANTIATE_TEST_SUITE_P(Kinds, Seated, testing::Values(true, false));

TEST_P(Seated, TheShoulderRestsOnFourPointsOnTheTrueRadius) {
  const Kind k = kind();
  for (const double yaw : {0.0, 0.3, 2.0}) {
    const Isometry3d X_WP = test::pose(0.4, -1.2, 0.93) * Eigen::AngleAxisd(0.7, Vector3d::UnitZ());
    const Isometry3d X_PG = test::pose(kX, kY, -10e-6) * Eigen::AngleAxisd(yaw, Vector3d::UnitZ());
    const auto found = contacts(k.gear, k.tray, X_PG, X_WP);
    ASSERT_EQ(found.size(), 4U);
    Vector3d sum = Vector3d::Zero();
    for (const Contact& c : found) {
      EXPECT_NEAR(c.depth_m, 10e-6, 1e-12);
      EXPECT_TRUE(c.n_W.isApprox(Vector3d::UnitZ(), 1e-12));
      const Vector3d p = (X_WP * X_PG).inverse() * c.p_W;
      EXPECT_NEAR(p.head<2>().norm(), k.gear.disc_radius_m, 1e-12);
      EXPECT_EQ(c.a, 3);
      EXPECT_EQ(c.b, 1);
      EXPECT_EQ(c.pair, SurfacePair::kGearTray);
      sum += p;
    }
    EXPECT_LT(sum.head<2>().norm(), 1e-9);
  }
}

TEST_P(Seated, ThePointsTurnWithTheGearWhileItIsLevel) {
  const Kind k = kind();
  const auto before = contacts(k.gear, k.tray, test::tilted(kX, kY, -10e-6, 3e-8, 0.4));
  const auto after = contacts(k.gear, k.tray, test::tilted(kX, kY, -10e-6, 3e-8, 2.9));
  ASSERT_EQ(before.size(), 4U);
  ASSERT_EQ(after.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_LT((before[i].p_W - after[i].p_W).norm(), 1e-6);
}

// A gear that is pushed against its wall would tip over the rim there: four body-fixed points would
// let it tip from 29 % less of a torque when it leans between two of them.
TEST_P(Seated, WhereItLeansItIsSupportedAtTheRim) {
  const Kind k = kind();
  for (const double heading : {0.0, 0.5, 0.25 * std::numbers::pi, 2.2, 4.0}) {
    const Vector3d d(std::cos(heading), std::sin(heading), 0);
    const Isometry3d X_PG = test::pose(kX + 1.5e-4 * d.x(), kY + 1.5e-4 * d.y(), -10e-6) *
                            Eigen::AngleAxisd(0.2, Vector3d::UnitZ());
    const auto found = contacts(k.gear, k.tray, X_PG);
    double reach = 0;
    int up = 0;
    for (const Contact& c : found) {
      if (c.n_W.z() < 0.99) continue;
      ++up;
      reach = std::max(reach, d.dot(c.p_W - X_PG.translation()));
    }
    EXPECT_EQ(up, 4);
    EXPECT_NEAR(reach, k.gear.disc_radius_m, 1e-9) << heading;
  }
}

TEST_P(Seated, NothingTouchesJustAboveTheSeat) {
  const Kind k = kind();
  EXPECT_TRUE(contacts(k.gear, k.tray, test::pose(kX, kY, 1e-9)).empty());
  EXPECT_TRUE(contacts(k.gear, k.tray, test::pose(kX + 1e-4, kY, 1e-9)).empty());
}

TEST(GearTray, BeyondTheClearanceTheConicalHubTouchesTheWall) {
  const scene::GearType g = test::conical_gear();
  const scene::TrayType t = test::conical_tray();
  const double slope = (0.0222 - 0.01498) / 0.0125, cosine = 1 / std::hypot(1, slope);
  const double z = 0.5e-3;  // lifted: no shoulder
  const double wall = 0.01498 + slope * (z - 0.012 + 0.0125);
  const double clearance = wall - 0.01507;
  EXPECT_TRUE(contacts(g, t, test::pose(kX + clearance - 1e-6, kY, z)).empty());
  const auto found = contacts(g, t, test::pose(kX + clearance + 5e-5, kY, z));
  ASSERT_GE(found.size(), 1U);
  const Contact& rim = found.front();
  EXPECT_NEAR(rim.depth_m, 5e-5 * cosine, 1e-10);
  EXPECT_TRUE(rim.n_W.isApprox(Vector3d(-cosine, 0, slope * cosine), 1e-9));
  EXPECT_NEAR(rim.p_W.x(), kX + clearance + 5e-5 + 0.01507, 1e-9);
  EXPECT_NEAR(rim.p_W.y(), kY, 1e-9);
}

TEST(GearTray, ACylindricalHubTouchesTheWallAtBothEndsOfTheLine) {
  const scene::GearType g = test::cylindrical_gear();
  const scene::TrayType t = test::cylindrical_tray();
  for (const double heading : {0.0, 0.3, 1.7, 4.0}) {
    const double off = 0.3e-3 + 4e-5;
    const Vector3d d(std::cos(heading), std::sin(heading), 0);
    const auto found = contacts(g, t, test::pose(kX + off * d.x(), kY + off * d.y(), 1e-6));
    ASSERT_EQ(found.size(), 2U) << heading;
    double low = 0, high = -1;
    for (const Contact& c : found) {
      EXPECT_NEAR(c.depth_m, 4e-5, 1e-9);
      EXPECT_LT((c.n_W + d).norm(), 1e-6);
      low = std::min(low, c.p_W.z());
      high = std::max(high, c.p_W.z());
    }
    EXPECT_NEAR(low, -0.006 + 0.0003 + 1e-6, 1e-9);  // upper end of the hub's chamfer
    EXPECT_NEAR(high, -0.001, 1e-9);                 // lower end of the mouth's
  }
}

TEST(GearTray, WhenSunkTheHubStillMeetsTheMouthInTheCorner) {
  scene::TrayType t = test::cylindrical_tray();
  for (scene::Slot& s : t.slots) s.pocket.chamfer_m = 0;
  const auto found = contacts(test::cylindrical_gear(), t, test::pose(kX + 0.34e-3, kY, -20e-6));
  int shoulder = 0, wall = 0;
  double high = -1;
  for (const Contact& c : found) {
    (c.n_W.z() > 0.9 ? shoulder : wall) += 1;
    if (c.n_W.z() < 0.1) high = std::max(high, c.p_W.z());
  }
  EXPECT_EQ(shoulder, 4);
  EXPECT_EQ(wall, 2);
  EXPECT_NEAR(high, 0, 1e-12);
}

TEST(GearTray, AJammedHubTouchesOppositeSides) {
  scene::GearType g = test::cylindrical_gear();
  g.disc_radius_m = 0.0101;  // lets it tilt
  scene::TrayType t = test::cylindrical_tray();
  for (scene::Slot& slot : t.slots) {
    slot.pocket.top_radius_m = slot.pocket.floor_radius_m = 0.01005;
  }
  const auto found =
      contacts(g, t, test::tilted(kX, kY, -0.0035, 0.16, 0.8) * test::pose(0, 0, 0.0032));
  double across = 0;
  for (const Contact& c : found) {
    for (const Contact& d : found) across = std::min(across, c.n_W.dot(d.n_W));
  }
  EXPECT_LT(across, -0.5);
}

TEST(GearTray, AHubBesideItsPocketStandsOnTheSlab) {
  const auto found =
      contacts(test::cylindrical_gear(), test::cylindrical_tray(), test::pose(0, 0, 0.006 - 10e-6));
  ASSERT_EQ(found.size(), 4U);
  for (const Contact& c : found) {
    EXPECT_NEAR(c.depth_m, 10e-6, 1e-12);
    EXPECT_NEAR(c.p_W.head<2>().norm(), 0.010 - 0.0003, 1e-12);
  }
}

TEST(GearTray, AHubHalfOverAPocketIsSupportedWhereTheSlabIs) {
  const scene::GearType g = test::cylindrical_gear();
  const scene::TrayType t = test::cylindrical_tray();
  const auto found = contacts(g, t, test::pose(kX - 0.012, kY, 0.006 - 10e-6));
  ASSERT_GE(found.size(), 3U);
  double least = 1, most = -1;
  for (const Contact& c : found) {
    EXPECT_NEAR(c.depth_m, 10e-6, 1e-9);
    const double from_pocket = (c.p_W - Vector3d(kX, kY, 0)).head<2>().norm();
    EXPECT_GT(from_pocket, 0.0113 - 1e-8);
    least = std::min(least, c.p_W.x());
    most = std::max(most, c.p_W.x());
  }
  EXPECT_LT(least, kX - 0.012 - 0.0096);
  // Rim and mouth circle cross here: nothing supports the hub farther in.
  const double cross = (0.012 * 0.012 + 0.0113 * 0.0113 - 0.0097 * 0.0097) / (2 * 0.012);
  EXPECT_NEAR(most, kX - cross, 1e-6);
}

TEST(GearTray, AGearHangingOverTheEdgeIsSupportedUpToTheEdge) {
  const scene::GearType g = test::conical_gear();
  scene::TrayType t = test::conical_tray();
  t.slots.clear();
  scene::GearType flat = g;  // no hub: the disc lies on the slab
  flat.hub_height_m = 0;
  const auto found = contacts(flat, t, test::pose(0.08 + 0.010, 0, -10e-6));
  ASSERT_GE(found.size(), 3U);
  double most = 0, half_chord = 0;
  for (const Contact& c : found) {
    EXPECT_NEAR(c.depth_m, 10e-6, 1e-9);
    EXPECT_TRUE(c.n_W.isApprox(Vector3d::UnitZ(), 1e-9));
    most = std::max(most, c.p_W.x());
    if (c.p_W.x() > 0.0799) half_chord = std::max(half_chord, std::abs(c.p_W.y()));
  }
  EXPECT_NEAR(most, 0.08, 1e-9);
  EXPECT_NEAR(half_chord, std::sqrt(0.032 * 0.032 - 0.010 * 0.010), 1e-9);
}

TEST(GearTray, AGearOverASlabsCornerIsSupportedByTheCorner) {
  scene::TrayType t = test::conical_tray();
  t.slots.clear();
  scene::GearType flat = test::conical_gear();
  flat.hub_height_m = 0;
  const auto found = contacts(flat, t, test::pose(0.09, 0.09, -10e-6));
  ASSERT_GE(found.size(), 3U);
  bool corner = false;
  for (const Contact& c : found) {
    EXPECT_TRUE(c.n_W.isApprox(Vector3d::UnitZ(), 1e-9));
    corner = corner || (c.p_W - Vector3d(0.08, 0.08, 0)).norm() < 1e-4;
  }
  EXPECT_TRUE(corner);
}

TEST(GearTray, AGearBesideTheSlabTouchesItsSide) {
  const scene::GearType g = test::conical_gear();
  const auto found = contacts(g, test::conical_tray(), test::pose(0.08 + 0.032 - 2e-5, 0, -0.003));
  ASSERT_GE(found.size(), 2U);
  for (const Contact& c : found) {
    EXPECT_LT((c.n_W - Vector3d::UnitX()).norm(), 1e-9);
    EXPECT_NEAR(c.depth_m, 2e-5, 1e-9);
  }
}

TEST(GearTray, UpsideDownTheGearStandsOnItsPeg) {
  const Isometry3d X =
      test::pose(0, 0, 0.026 - 10e-6) * Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitX());
  const auto found = contacts(test::conical_gear(), test::conical_tray(), X);
  ASSERT_EQ(found.size(), 4U);
  for (const Contact& c : found) {
    EXPECT_NEAR(c.depth_m, 10e-6, 1e-12);
    EXPECT_NEAR(c.p_W.head<2>().norm(), 0.00385, 1e-9);
    EXPECT_TRUE(c.n_W.isApprox(Vector3d::UnitZ(), 1e-9));
  }
}

TEST(GearTray, ThePegStandsOnAPocketsFloorUpsideDown) {
  const Isometry3d X = test::pose(kX, kY, -0.0125 + 0.026 - 10e-6) *
                       Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitX());
  const auto found = contacts(test::conical_gear(), test::conical_tray(), X);
  ASSERT_EQ(found.size(), 4U);
  for (const Contact& c : found) EXPECT_NEAR(c.depth_m, 10e-6, 1e-12);
}

TEST(GearTray, AThinFloorPushesAGearBackUp) {
  // 2.2 mm into the 2.5 mm floor: still upwards, not out through the underside.
  scene::GearType g = test::conical_gear();
  g.disc_radius_m = 0.022;  // no shoulder
  const auto found = contacts(g, test::conical_tray(), test::pose(kX, kY, -0.0027));
  double up = 0;
  for (const Contact& c : found) up = std::max(up, c.n_W.z() * c.depth_m);
  EXPECT_GT(up, 1e-3);
}

// Never up into the pocket: the two together would squeeze it, and the one alone pull it through.
TEST(GearTray, AThinFloorPushesAGearThatComesFromBelowBackDown) {
  for (const double tilt : {0.0, 0.1}) {
    for (double depth = 2e-4; depth < 2.4e-3; depth += 2e-4) {
      const double z = -0.015 - 0.026 * std::cos(tilt) + depth;
      const auto found =
          contacts(test::conical_gear(), test::conical_tray(), test::tilted(kX, kY, z, tilt, 0.3));
      ASSERT_FALSE(found.empty()) << depth;
      for (const Contact& c : found) EXPECT_LT(c.n_W.z(), 0) << depth << " at tilt " << tilt;
    }
  }
}

// Stuck deep in the slab, a gear is pushed out the near way; not also the way right through, for
// the two would squeeze it with any force.
TEST(GearTray, NothingStuckInTheSlabIsSqueezed) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  int squeezed = 0;
  for (int i = 0; i < 20000; ++i) {
    const double x = 0.09 * uniform(random), y = 0.09 * uniform(random);
    const double z = 0.03 * uniform(random), tilt = std::numbers::pi * uniform(random);
    const Isometry3d X = test::tilted(x, y, z, tilt, std::numbers::pi * uniform(random));
    const auto found = contacts(test::conical_gear(), test::conical_tray(), X);
    for (const Contact& c : found) {
      for (const Contact& d : found) {
        const bool through = c.depth_m > 1e-3 && c.depth_m > 2 * d.depth_m;
        squeezed += through && c.n_W.dot(d.n_W) < -0.5;
      }
    }
  }
  EXPECT_EQ(squeezed, 0);
}

}  // namespace
}  // namespace aprsim::physics
