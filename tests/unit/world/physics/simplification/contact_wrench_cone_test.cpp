#include "world/physics/simplification/contact_wrench_cone.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "world/physics/bodies/mass_properties.hpp"

namespace aprsim::physics::test {
namespace {

using Eigen::Vector3d;

constexpr double kMu = 0.4;
constexpr double kRadius = 0.02;

/// Points on a circle of kRadius in the plane z = 0, the first at angle `turn`.
ContactWrenchCone disc(int points, double turn = 0.3) {
  ContactWrenchCone support;
  for (int i = 0; i < points; ++i) {
    const double angle = turn + 2 * std::numbers::pi * i / points;
    support.add(kRadius * Vector3d(std::cos(angle), std::sin(angle), 0), Vector3d::UnitZ(), kMu);
  }
  support.finish();
  return support;
}

/// A force that acts at `p`.
Wrench at(const Vector3d& p, const Vector3d& force) { return {force, p.cross(force)}; }

TEST(ContactWrenchCone, SlidingForceIsBoundedByTheConeInEveryDirection) {
  const ContactWrenchCone support = disc(4);
  for (int k = 0; k < 24; ++k) {
    const double angle = 0.11 + 2 * std::numbers::pi * k / 24;
    const Vector3d along(std::cos(angle), std::sin(angle), 0);
    const Vector3d up = 3 * Vector3d::UnitZ();
    EXPECT_TRUE(support.contains(at({0, 0, 0}, up + 3 * kMu * (1 - 1e-6) * along))) << k;
    EXPECT_FALSE(support.contains(at({0, 0, 0}, up + 3 * kMu * (1 + 1e-6) * along))) << k;
  }
}

TEST(ContactWrenchCone, NothingPulls) {
  const ContactWrenchCone support = disc(4);
  EXPECT_FALSE(support.contains(at({0, 0, 0}, {0, 0, -1e-3})));
  EXPECT_FALSE(support.contains(at({0, 0, 0}, {1e-3, 0, 0})));
  EXPECT_TRUE(support.contains(Wrench{}));
}

TEST(ContactWrenchCone, CentreOfPressureStaysInThePolygon) {
  const ContactWrenchCone support = disc(4, 0);  // corners on the axes
  const Vector3d up(0, 0, 2);
  EXPECT_TRUE(support.contains(at({0.0199, 0, 0}, up)));
  EXPECT_FALSE(support.contains(at({0.0201, 0, 0}, up)));
  EXPECT_TRUE(support.contains(at({0.0099, 0.0099, 0}, up)));
  EXPECT_FALSE(support.contains(at({0.0101, 0.0101, 0}, up)));
}

// A horizontal force at height h tips at f h = N r.
TEST(ContactWrenchCone, TippingAtTheClosedForm) {
  const ContactWrenchCone support = disc(4, 0);
  const double height = 0.06, limit = 2 * kRadius / height;  // < mu N
  EXPECT_TRUE(support.contains(at({0, 0, height}, {0.9999 * limit, 0, 2})));
  EXPECT_FALSE(support.contains(at({0, 0, height}, {1.0001 * limit, 0, 2})));
}

// N mu r, all points at the same distance.
TEST(ContactWrenchCone, TurningMomentIsBounded) {
  const ContactWrenchCone support = disc(4);
  const double limit = kMu * 2 * kRadius;
  EXPECT_TRUE(support.contains({{0, 0, 2}, {0, 0, 0.99 * limit}}));
  EXPECT_FALSE(support.contains({{0, 0, 2}, {0, 0, 1.01 * limit}}));
  EXPECT_FALSE(support.contains({{0.3 * 2 * kMu, 0, 2}, {0, 0, 0.99 * limit}}));
}

// A hub against the wall of its pocket: the wall takes what friction can not, but only pushing.
TEST(ContactWrenchCone, WallsPushToo) {
  ContactWrenchCone support;
  for (int i = 0; i < 4; ++i) {
    const double angle = std::numbers::pi / 4 + std::numbers::pi / 2 * i;
    support.add(kRadius * Vector3d(std::cos(angle), std::sin(angle), 0), Vector3d::UnitZ(), kMu);
  }
  for (const double y : {-0.008, 0.008}) {
    support.add({-0.01, y, -0.003}, Vector3d::UnitX(), kMu);
  }
  support.finish();
  EXPECT_TRUE(support.contains(at({0, 0, 0}, {3, 0, 2})));
  EXPECT_FALSE(support.contains(at({0, 0, 0}, {-3, 0, 2})));
  EXPECT_TRUE(support.contains(at({0, 0, 0}, {-0.79, 0, 2})));
}

TEST(ContactWrenchCone, AnEdgeOrAPointBearsNoMomentAcross) {
  ContactWrenchCone edge;
  edge.add({0, -0.01, 0}, Vector3d::UnitZ(), kMu);
  edge.add({0, 0.01, 0}, Vector3d::UnitZ(), kMu);
  edge.finish();
  EXPECT_TRUE(edge.contains(at({0, 0.005, 0}, {0, 0.1, 1})));
  EXPECT_FALSE(edge.contains(at({0.001, 0, 0}, {0, 0, 1})));
}

// Two halves of a box, turned and moved, are the box: mass, centre and all products of inertia.
TEST(CombinedMass, HalvesMakeTheWhole) {
  const auto box = [](const Vector3d& size, const Vector3d& centre) {
    MassProperties m;
    m.mass_kg = 700 * size.prod();
    m.com = centre;
    const Vector3d s = size.cwiseAbs2() * m.mass_kg / 12;
    m.inertia = Vector3d(s.y() + s.z(), s.x() + s.z(), s.x() + s.y()).asDiagonal();
    return m;
  };
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  X.translation() = Vector3d(0.1, -0.2, 0.05);
  MassProperties whole = box({0.2, 0.1, 0.05}, {0.02, 0.01, -0.01});
  const MassProperties left = box({0.1, 0.1, 0.05}, {-0.03, 0.01, -0.01});
  MassProperties right = box({0.1, 0.1, 0.05}, {0, 0, 0});
  // The right half in a frame of its own.
  right.com = X.inverse() * Vector3d(0.07, 0.01, -0.01);
  right.inertia = X.linear().transpose() * right.inertia * X.linear();
  const MassProperties sum = combined(left, right, X);
  EXPECT_NEAR(sum.mass_kg, whole.mass_kg, 1e-15);
  EXPECT_LT((sum.com - whole.com).norm(), 1e-16);
  EXPECT_LT((sum.inertia - whole.inertia).norm(), 1e-16);
}

}  // namespace
}  // namespace aprsim::physics::test
