#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <sstream>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/world/physics/collision/solids.hpp"

namespace aprsim::physics {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

std::vector<Contact> touch(const scene::GearType& a, const Isometry3d& X_WA,
                           const scene::GearType& b, const Isometry3d& X_WB) {
  std::vector<Contact> out;
  gear_gear(a, X_WA, b, X_WB, 5, 6, out);
  return out;
}

std::vector<Contact> touch(const Isometry3d& X_WA, const Isometry3d& X_WB) {
  return touch(test::conical_gear(), X_WA, test::conical_gear(), X_WB);
}

TEST(GearGear, SideBySideTheyTouchAtBothEndsOfTheirHeight) {
  const double gap = 0.064 - 2e-5;
  for (const double heading : {0.0, 0.9, 3.0}) {
    const Vector3d d(std::cos(heading), std::sin(heading), 0);
    const auto found = touch(test::pose(gap * d.x(), gap * d.y(), 0.1), test::pose(0, 0, 0.1));
    ASSERT_EQ(found.size(), 2U);
    Vector3d middle = Vector3d::Zero();
    for (const Contact& c : found) {
      EXPECT_EQ(c.a, 5);
      EXPECT_EQ(c.b, 6);
      EXPECT_EQ(c.pair, SurfacePair::kGearGear);
      EXPECT_NEAR(c.depth_m, 2e-5, 1e-12);
      EXPECT_TRUE(c.n_W.isApprox(d, 1e-9));
      middle += 0.5 * c.p_W;
    }
    EXPECT_NEAR(middle.z(), 0.103, 1e-9);  // no torque that tips them
    EXPECT_LT((middle.head<2>() - 0.5 * gap * d.head<2>()).norm(), 1e-9);
  }
}

TEST(GearGear, AtDifferentHeightsTheyTouchWhereBothAre) {
  const auto found = touch(test::pose(0.064 - 2e-5, 0, 0.004), test::pose(0, 0, 0));
  ASSERT_EQ(found.size(), 2U);
  double low = 1, high = 0;
  for (const Contact& c : found) {
    low = std::min(low, c.p_W.z());
    high = std::max(high, c.p_W.z());
  }
  EXPECT_NEAR(low, 0.004, 1e-12);
  EXPECT_NEAR(high, 0.006, 1e-12);
}

// A body that slides along the normal's plane neither sinks in nor gets out, also on the side of a
// leaning one.
TEST(GearGear, LeaningSideBySideTheNormalIsTheSlopeOfTheDepth) {
  constexpr double kBy = 1e-7, kSlope = 0.03, kNear = 1e-4;
  std::mt19937_64 random(52);
  int checked = 0, leaning = 0;
  for (int i = 0; i < 300; ++i) {
    const double heading = test::uniform(random, 0, 2 * std::numbers::pi);
    const Vector3d across(std::cos(heading), std::sin(heading), 0);
    const double tilt_heading = test::uniform(random, 0, 2 * std::numbers::pi);
    Isometry3d X = test::pose((0.064 - 2e-4) * across.x(), (0.064 - 2e-4) * across.y(),
                              test::uniform(random, -3e-3, 3e-3));
    X.rotate(Eigen::AngleAxisd(test::uniform(random, 0.02, 0.15),
                               Vector3d(std::cos(tilt_heading), std::sin(tilt_heading), 0)));
    const Isometry3d X_WB = test::pose(0, 0, 0);
    for (const Contact& c : touch(X, X_WB)) {
      if (c.depth_m <= 1e-5 || c.depth_m > 3e-4 || c.n_W.dot(across) < 0.9) continue;
      const auto depth_when = [&](const Vector3d& moved) {
        Isometry3d there = X;
        there.translation() += moved;
        for (const Contact& other : touch(there, X_WB)) {
          if ((other.p_W - c.p_W).norm() < kNear) return other.depth_m;
        }
        return std::nan("");
      };
      for (const Vector3d& axis : {Vector3d(1, 0, 0), Vector3d(0, 1, 0), Vector3d(0, 0, 1)}) {
        const double slope = (depth_when(kBy * axis) - depth_when(-kBy * axis)) / (2 * kBy);
        EXPECT_NEAR(slope, -c.n_W.dot(axis), kSlope) << i << " at " << c.p_W.transpose();
      }
      ++checked;
      leaning += std::abs(c.n_W.z()) > 0.02;
    }
  }
  EXPECT_GT(checked, 100);
  EXPECT_GT(leaning, 20);
}

TEST(GearGear, ApartTheyDoNotTouch) {
  EXPECT_TRUE(touch(test::pose(0.0640001, 0, 0), test::pose(0, 0, 0)).empty());
  EXPECT_TRUE(touch(test::pose(0.05, 0, 0.0191), test::pose(0, 0, 0)).empty());
}

TEST(GearGear, OneOnTopOfTheOther) {
  // A's hub stands on B's disc beside B's peg.
  scene::GearType a = test::cylindrical_gear();
  const auto found = touch(a, test::pose(0.015, 0, 0.006 + 0.006 - 1e-5), test::conical_gear(),
                           Isometry3d::Identity());
  ASSERT_EQ(found.size(), 4U);
  for (const Contact& c : found) {
    EXPECT_NEAR(c.depth_m, 1e-5, 1e-12);
    EXPECT_TRUE(c.n_W.isApprox(Vector3d::UnitZ(), 1e-12));
  }
}

TEST(GearGear, HalfOverTheOtherTheSupportEndsAtItsRim) {
  scene::GearType a = test::cylindrical_gear();
  a.disc_radius_m = 0.02;  // clear of the other's peg
  const auto found =
      touch(a, test::pose(0.028, 0, 0.012 - 1e-5), test::conical_gear(), Isometry3d::Identity());
  ASSERT_GE(found.size(), 3U);
  double most = 0;
  for (const Contact& c : found) {
    EXPECT_NEAR(c.depth_m, 1e-5, 1e-9);
    EXPECT_LE(c.p_W.head<2>().norm(), 0.032 + 1e-9);
    most = std::max(most, c.p_W.head<2>().norm());
  }
  EXPECT_NEAR(most, 0.032, 1e-6);
}

TEST(GearGear, TheTopOfAPegCarriesAHub) {
  const auto found = touch(test::pose(0.002, 0, 0.026 + 0.012 - 1e-5), Isometry3d::Identity());
  ASSERT_EQ(found.size(), 4U);
  for (const Contact& c : found) {
    EXPECT_NEAR(c.depth_m, 1e-5, 1e-12);
    EXPECT_NEAR(c.p_W.head<2>().norm(), 0.00385, 1e-9);
    EXPECT_TRUE(c.n_W.isApprox(Vector3d::UnitZ(), 1e-12));
  }
}

// Also where it is deeper inside than the hub's chamfer is high.
TEST(GearGear, TheRimOfAPegStandsAgainstATiltedHub) {
  const scene::GearType a = test::cylindrical_gear(), b = test::conical_gear();
  const Vector3d n = Vector3d(0.2, 0, 1).normalized();
  const Vector3d rim(b.peg_radius_m, 0, b.peg_top_m);
  Isometry3d X_WA = Isometry3d::Identity();
  X_WA.linear() = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), n).toRotationMatrix();
  for (const double depth : {1e-5, 1.4e-4, 1.6e-4, 2.9e-4, 3.1e-4, 6e-4}) {
    const Vector3d at_A(0.008, 0, depth - a.hub_height_m);
    X_WA.translation() = rim - X_WA.linear() * at_A;
    const auto found = touch(a, X_WA, b, Isometry3d::Identity());
    ASSERT_FALSE(found.empty()) << depth;
    EXPECT_NEAR(test::deepest(found), depth, 0.01 * depth + 1e-9);
    for (const Contact& c : found) EXPECT_GT(c.n_W.dot(n), 0.99) << depth;
  }
}

// A disc that leans leans over the other's edge: the heights of its near side count, not its axis'.
TEST(GearGear, ALeaningDiscAboveTheOtherOverlapsLittle) {
  const scene::GearType g = test::cylindrical_gear();
  for (const double lean : {-0.15, -0.1, 0.1, 0.15}) {
    Isometry3d X_WA = Isometry3d::Identity();
    X_WA.linear() = Eigen::AngleAxisd(lean, Vector3d::UnitY()).toRotationMatrix();
    // The lowest point of its near side a little below the other's top face, well inside its edge.
    const Vector3d near_A(-g.disc_radius_m, 0, 0);
    const double depth = 2e-5;
    X_WA.translation() =
        Vector3d(g.disc_radius_m - 0.003, 0, g.disc_height_m - depth) - X_WA.linear() * near_A;
    for (const Contact& c : touch(g, X_WA, g, Isometry3d::Identity())) {
      EXPECT_LT(c.depth_m, 1e-3) << lean << " " << c.n_W.transpose();
    }
  }
}

TEST(GearGear, CrossedPegsTouchInOnePoint) {
  scene::GearType rod = test::conical_gear();
  const Isometry3d X_WA = test::pose(2 * 0.00385 - 1e-5, 0.0, 0.016) *
                          Eigen::AngleAxisd(std::numbers::pi / 2, Vector3d::UnitX()) *
                          test::pose(0, 0, -0.016);
  const auto found = touch(rod, X_WA, rod, Isometry3d::Identity());
  ASSERT_FALSE(found.empty());
  bool seen = false;
  for (const Contact& c : found) {
    seen = seen || (std::abs(c.depth_m - 1e-5) < 1e-9 && c.n_W.isApprox(Vector3d::UnitX(), 1e-9));
  }
  EXPECT_TRUE(seen);
}

/// Deepest rim point of one gear in the other, both ways.
double overlap(const scene::GearType& g, const Isometry3d& X_BA) {
  static const std::vector<Vector3d> points = [&] {
    auto all = test::gear_rims(g, 720);
    for (const Vector3d& p : test::gear_surface(g, 48)) all.push_back(p);
    return all;
  }();
  double depth = 0;
  const Isometry3d X_AB = X_BA.inverse();
  for (const Vector3d& p : points) {
    for (const Isometry3d* X : {&X_BA, &X_AB}) {
      const Vector3d q = *X * p;
      const double r2 = q.head<2>().squaredNorm();
      if (q.z() > -0.012 && q.z() < 0.026 && r2 < 0.032 * 0.032)
        depth = std::max(depth, -test::gear_distance(g, q));
    }
  }
  return depth;
}

TEST(GearGear, RandomPosesAgreeWithDenseSampling) {
  const scene::GearType g = test::conical_gear();
  std::mt19937_64 random(31);
  int touching = 0, close = 0;
  for (int i = 0; i < 200; ++i) {
    const Isometry3d X_WB = test::random_rotation(random);
    Isometry3d X_BA = test::random_rotation(random);
    Vector3d d(test::uniform(random, -1, 1), test::uniform(random, -1, 1),
               test::uniform(random, -1, 1));
    d.normalize();
    double near = 0, far = 0.1;  // approached until they overlap a little
    const double aim = test::uniform(random, 2e-5, 3e-4);
    for (int k = 0; k < 15; ++k) {
      X_BA.translation() = 0.5 * (near + far) * d;
      (overlap(g, X_BA) < aim ? far : near) = 0.5 * (near + far);
    }
    X_BA.translation() = near * d;
    const double depth = overlap(g, X_BA);
    if (depth > 5e-4 || depth < 5e-6) continue;
    ++touching;
    const auto found = touch(g, X_WB * X_BA, g, X_WB);
    std::ostringstream where;
    where.precision(17);
    where << X_BA.translation().transpose() << " "
          << Eigen::Quaterniond(X_BA.linear()).coeffs().transpose();
    EXPECT_FALSE(found.empty()) << where.str() << " overlap " << depth;
    EXPECT_LE(found.size(), 8U);
    const double seen = test::deepest(found);
    EXPECT_GE(seen, 0.8 * depth - 1e-6) << i;
    EXPECT_LE(seen, 4 * depth + 1.5e-4) << i;
    close += seen < 1.3 * depth;
    for (const Contact& c : found) {
      const Vector3d in_b = X_WB.inverse() * c.p_W;
      EXPECT_LE(test::gear_distance(g, in_b), 1e-7) << i;
      EXPECT_LE(test::gear_distance(g, X_BA.inverse() * in_b), 1e-7) << i;
    }
  }
  EXPECT_GT(touching, 100);
  EXPECT_GT(close, touching / 2);
}

}  // namespace
}  // namespace aprsim::physics
