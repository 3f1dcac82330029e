#include "world/scene/checks/overlap.hpp"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace aprsim::scene {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Translation3d;
using Eigen::Vector3d;

Solid box(const Vector3d& half, const Isometry3d& X) { return {BoxSolid{half}, X}; }
Solid cylinder(double radius, double half_height, const Isometry3d& X) {
  return {FrustumSolid{half_height, radius, radius}, X};
}
Isometry3d at(double x, double y, double z, double yaw = 0) {
  return Translation3d(x, y, z) * AngleAxisd(yaw, Vector3d::UnitZ());
}

TEST(Overlap, BoxesByTheirSmallestDepth) {
  const Solid a = box({1, 1, 1}, at(0, 0, 0));
  EXPECT_NEAR(overlap_depth(a, box({1, 1, 1}, at(1.9, 0.5, 0))), 0.1, 1e-12);
  EXPECT_NEAR(overlap_depth(a, box({1, 1, 1}, at(2, 0, 0))), 0, 1e-12);
  EXPECT_LE(overlap_depth(a, box({1, 1, 1}, at(2.1, 0, 0))), 0);
}

TEST(Overlap, TurnedBoxReachesFurtherWithItsCorner) {
  const Solid a = box({1, 1, 1}, at(0, 0, 0));
  const double corner = std::sqrt(2.0);
  const Solid turned = box({1, 1, 1}, at(1 + corner - 0.2, 0, 0, std::numbers::pi / 4));
  EXPECT_NEAR(overlap_depth(a, turned), 0.2, 1e-12);
}

TEST(Overlap, EdgesCrossingNeedTheirCrossProduct) {
  // Two bars with their edges towards each other, each turned 45 degrees about its own length.
  const Isometry3d lower(AngleAxisd(std::numbers::pi / 4, Vector3d::UnitX()));
  const Isometry3d upper(Translation3d(0, 0, 2 * std::sqrt(2.0) + 0.01) *
                         AngleAxisd(std::numbers::pi / 4, Vector3d::UnitY()));
  EXPECT_LE(overlap_depth(box({5, 1, 1}, lower), box({1, 5, 1}, upper)), 0);
}

TEST(Overlap, UprightCylindersByRadius) {
  const Solid a = cylinder(0.05, 0.01, at(0, 0, 0));
  EXPECT_NEAR(overlap_depth(a, cylinder(0.03, 0.01, at(0.042, 0.056, 0))), 0.01, 1e-12);
  EXPECT_LE(overlap_depth(a, cylinder(0.03, 0.01, at(0.0801, 0, 0))), 0);
  EXPECT_LE(overlap_depth(a, cylinder(0.03, 0.01, at(0, 0, 0.0201))), 0);
}

TEST(Overlap, CylinderBesideABoxsCorner) {
  const Solid corner = box({1, 1, 1}, at(0, 0, 0));
  const double r = 0.5;
  const Vector3d out = Vector3d(1, 1, 0).normalized();
  const Vector3d near = Vector3d(1, 1, 0) + (r - 0.01) * out;
  const Vector3d apart = Vector3d(1, 1, 0) + (r + 0.01) * out;
  EXPECT_NEAR(overlap_depth(corner, cylinder(r, 1, at(near.x(), near.y(), 0))), 0.01, 1e-9);
  EXPECT_LE(overlap_depth(corner, cylinder(r, 1, at(apart.x(), apart.y(), 0))), 0);
}

TEST(Overlap, FrustumLeansInwards) {
  // A cone frustum 0.5 wide below and 0.1 above: at its top a wall can stand nearer.
  const Solid frustum{FrustumSolid{1, 0.5, 0.1}, Isometry3d::Identity()};
  EXPECT_LE(overlap_depth(frustum, box({0.2, 1, 0.5}, at(0.62, 0, 0.5))), 0);
  EXPECT_GT(overlap_depth(frustum, box({0.2, 1, 0.5}, at(0.62, 0, -0.5))), 0.07);
}

TEST(Overlap, DepthBelowGround) {
  EXPECT_NEAR(depth_below_ground(box({1, 1, 0.5}, at(0, 0, 0.4))), 0.1, 1e-12);
  EXPECT_NEAR(depth_below_ground(
                  cylinder(0.2, 1,
                           Translation3d(0, 0, 0.2) *
                               Isometry3d(AngleAxisd(std::numbers::pi / 2, Vector3d::UnitX())))),
              0, 1e-12);
}

Solid random_solid(std::mt19937& random) {
  std::uniform_real_distribution<double> size(0.02, 0.2), place(-0.3, 0.3), turn(-1, 1);
  Eigen::Quaterniond q(turn(random), turn(random), turn(random), turn(random));
  q.normalize();
  const Isometry3d X = Translation3d(place(random), place(random), place(random)) * q;
  if (random() % 2 == 0) return box({size(random), size(random), size(random)}, X);
  return {FrustumSolid{size(random), size(random), size(random)}, X};
}

/// A point inside the solid, drawn from its whole volume.
Vector3d point_inside(const Solid& solid, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  const Vector3d u(unit(random), unit(random), unit(random));
  if (const auto* b = std::get_if<BoxSolid>(&solid.shape)) {
    return solid.X_WS * u.cwiseProduct(b->half_size);
  }
  const auto& f = std::get<FrustumSolid>(solid.shape);
  const double radius = f.radius_bottom + (f.radius_top - f.radius_bottom) * (u.z() + 1) / 2;
  const double share = std::sqrt(std::abs(u.x())), angle = std::numbers::pi * u.y();
  return solid.X_WS * Vector3d(radius * share * std::cos(angle), radius * share * std::sin(angle),
                               u.z() * f.half_height);
}

bool contains(const Solid& solid, const Vector3d& p_W) {
  const Vector3d p = solid.X_WS.inverse() * p_W;
  if (const auto* b = std::get_if<BoxSolid>(&solid.shape)) {
    return (p.cwiseAbs().array() <= b->half_size.array()).all();
  }
  const auto& f = std::get<FrustumSolid>(solid.shape);
  const double up = (p.z() + f.half_height) / (2 * f.half_height);
  return up >= 0 && up <= 1 &&
         p.head<2>().norm() <= f.radius_bottom + (f.radius_top - f.radius_bottom) * up;
}

TEST(Overlap, SolidsInAnyPostureThatShareAPointOverlap) {
  std::mt19937 random(1);
  int overlapping = 0;
  for (int pair = 0; pair < 5000; ++pair) {
    const Solid a = random_solid(random), b = random_solid(random);
    const double depth = overlap_depth(a, b);
    EXPECT_EQ(depth > 0, overlap_depth(b, a) > 0) << pair;
    for (int i = 0; i < 50; ++i) {
      if (!contains(b, point_inside(a, random))) continue;
      ++overlapping;
      EXPECT_GT(depth, 0) << pair;
      break;
    }
  }
  EXPECT_GT(overlapping, 200);
}

TEST(Overlap, SolidsMovedApartAlongAnAxisDoNotOverlap) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> turn(-1, 1);
  for (int pair = 0; pair < 5000; ++pair) {
    const Solid a = random_solid(random);
    Solid b = random_solid(random);
    const Vector3d d = Vector3d(turn(random), turn(random), turn(random)).normalized();
    // Exactly 0.05 mm apart along d, whatever the rest.
    const double gap = d.dot(b.support(-d) - a.support(d));
    b.X_WS.pretranslate(d * (5e-5 - gap));
    EXPECT_LE(overlap_depth(a, b), 0) << pair;
  }
}

}  // namespace
}  // namespace aprsim::scene
