#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/world/physics/collision/solids.hpp"

namespace aprsim::physics {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

const Vector3d kBelt(3, 0.6, 0.1);
const Isometry3d kBeltPose = test::pose(0, 0, -0.05);  // top face at z = 0

std::vector<Contact> on_belt(const scene::GearType& g, const Isometry3d& X) {
  std::vector<Contact> out;
  gear_box(g, X, kBelt, kBeltPose, 4, kGround, SurfacePair::kGearBelt, out);
  return out;
}

double lowest(const scene::GearType& g, const Isometry3d& X) {
  double z = 1;
  for (const Vector3d& p : test::gear_rims(g, 7200)) z = std::min(z, (X * p).z());
  return z;
}

TEST(GearBox, StandingOnItsHub) {
  const scene::GearType g = test::conical_gear();
  const auto found = on_belt(g, test::pose(0.3, 0.1, 0.012 - 1e-5));
  ASSERT_EQ(found.size(), 4U);
  for (const Contact& c : found) {
    EXPECT_EQ(c.a, 4);
    EXPECT_EQ(c.b, kGround);
    EXPECT_EQ(c.pair, SurfacePair::kGearBelt);
    EXPECT_NEAR(c.depth_m, 1e-5, 1e-12);
    EXPECT_NEAR((c.p_W - Vector3d(0.3, 0.1, 0)).head<2>().norm(), 0.01507, 1e-12);
    EXPECT_TRUE(c.n_W.isApprox(Vector3d::UnitZ(), 1e-12));
  }
}

// As at the predicted pose of a falling gear: the first surface to touch carries it.
TEST(GearBox, SunkDeeperThanItsChamfer) {
  scene::GearType g = test::conical_gear();
  g.hub_chamfer_m = 3e-4;
  const double depth = 4e-4;
  const auto found = on_belt(g, test::pose(0, 0, g.hub_height_m - depth));
  ASSERT_EQ(found.size(), 4U);
  for (const Contact& c : found) EXPECT_NEAR(c.depth_m, depth, 1e-12);
}

TEST(GearBox, UpsideDownOnItsPeg) {
  const Isometry3d X =
      test::pose(0, 0, 0.026 - 1e-5) * Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitY());
  const auto found = on_belt(test::conical_gear(), X);
  ASSERT_EQ(found.size(), 4U);
  for (const Contact& c : found) {
    EXPECT_NEAR(c.depth_m, 1e-5, 1e-12);
    EXPECT_NEAR(c.p_W.head<2>().norm(), 0.00385, 1e-9);
  }
}

TEST(GearBox, FallenOverItLiesOnDiscAndHub) {
  // Axis inclined so that disc rim and hub rim touch together.
  const scene::GearType g = test::conical_gear();
  const double tilt = std::atan2(0.012, 0.032 - 0.01507);
  Isometry3d X(Eigen::AngleAxisd(tilt, Vector3d::UnitY()));
  X.translation().z() = -lowest(g, X) - 1e-5;
  const auto found = on_belt(g, X);
  double disc = 0, hub = 0;
  for (const Contact& c : found) {
    EXPECT_TRUE(c.n_W.isApprox(Vector3d::UnitZ(), 1e-9));
    const Vector3d p = X.inverse() * c.p_W;
    const double r = p.head<2>().norm();
    if (std::abs(r - 0.032) < 1e-9 && std::abs(p.z()) < 1e-9) disc = c.depth_m;
    if (std::abs(r - 0.01507) < 1e-9) hub = c.depth_m;
  }
  EXPECT_NEAR(disc, 1e-5, 1e-7);
  EXPECT_NEAR(hub, 1e-5, 1e-7);
}

TEST(GearBox, RollingOnItsDiscTheLowestPointIsExact) {
  const scene::GearType g = test::conical_gear();
  for (const double tilt : {0.002, 0.05, 0.3}) {
    for (const double heading : {0.0, 0.5, 2.0, 4.4}) {
      Isometry3d X = test::tilted(0, 0, 0, tilt, heading);
      const double drop = 0.01507 * std::sin(tilt) + 0.012 * std::cos(tilt);  // hub rim, exactly
      X.translation().z() = drop - 1e-5;
      EXPECT_NEAR(test::deepest(on_belt(g, X)), 1e-5, 1e-12) << tilt << " " << heading;
    }
  }
}

TEST(GearBox, OverTheBeltsEdgeItTips) {
  scene::GearType g = test::conical_gear();
  const auto found = on_belt(g, test::pose(1.5 + 0.002, 0, 0.012 - 1e-5));
  ASSERT_GE(found.size(), 3U);
  double most = 0;
  for (const Contact& c : found) most = std::max(most, c.p_W.x());
  EXPECT_NEAR(most, 1.5, 1e-9);  // short of the centre of mass: it falls
}

TEST(GearBox, ADiscAgainstAWallTouchesAlongItsHeight) {
  const scene::GearType g = test::conical_gear();
  std::vector<Contact> out;
  gear_box(g, test::pose(0.05 + 0.032 - 2e-5, 0, 0), {0.1, 0.4, 0.4}, Isometry3d::Identity(), 0,
           kGround, SurfacePair::kGearGround, out);
  ASSERT_EQ(out.size(), 2U);
  for (const Contact& c : out) {
    EXPECT_NEAR(c.depth_m, 2e-5, 1e-12);
    EXPECT_TRUE(c.n_W.isApprox(Vector3d::UnitX(), 1e-9));
  }
  EXPECT_NEAR(std::abs(out[0].p_W.z() - out[1].p_W.z()), 0.006, 1e-9);
}

TEST(GearBox, ATabletopsEdgeAgainstTheDiscsSide) {
  // The disc's side stands against the top edge of a table that ends in the middle of its height.
  const scene::GearType g = test::conical_gear();
  std::vector<Contact> out;
  gear_box(g, test::pose(0.5 + 0.032 - 2e-5, 0, -0.003), {1, 1, 0.1}, test::pose(0, 0, -0.05), 0,
           kGround, SurfacePair::kGearGround, out);
  ASSERT_GE(out.size(), 2U);
  for (const Contact& c : out) {
    EXPECT_NEAR(c.depth_m, 2e-5, 1e-9);
    EXPECT_LT((c.n_W - Vector3d::UnitX()).norm(), 1e-6);
    EXPECT_LE(c.p_W.z(), 1e-9);
  }
}

}  // namespace
}  // namespace aprsim::physics
