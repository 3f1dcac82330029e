#include "world/robot/avoidance/convex_shape.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace aprsim::robot {
namespace {

constexpr double kFar = 1e9;
constexpr double kTolerance_m = 1.1e-5;

Eigen::Isometry3d at(double x, double y, double z) {
  return Eigen::Isometry3d(Eigen::Translation3d(x, y, z));
}

ConvexShape sphere(double radius) { return convex_shape(SphereShape{radius}); }
ConvexShape capsule(double radius, double length) {
  return convex_shape(CapsuleShape{radius, length});
}
ConvexShape cylinder(double radius, double length) {
  return convex_shape(CylinderShape{radius, length});
}

double distance(const ConvexShape& a, const Eigen::Isometry3d& X_WA, const ConvexShape& b,
                const Eigen::Isometry3d& X_WB) {
  return distance_bound(a, X_WA, b, X_WB, kFar);
}

TEST(ConvexShape, DistancesOfAlignedShapes) {
  EXPECT_NEAR(distance(sphere(0.1), at(0, 0, 0), sphere(0.2), at(1, 0, 0)), 0.7, kTolerance_m);
  EXPECT_NEAR(distance(capsule(0.1, 1), at(0, 0, 0), capsule(0.1, 1), at(0.5, 0, 0.3)), 0.3,
              kTolerance_m);
  EXPECT_NEAR(distance(capsule(0.1, 1), at(0, 0, 0), sphere(0.1), at(0, 0, 1)), 0.3, kTolerance_m);
  const ConvexShape box = convex_box({1, 1, 1});
  EXPECT_NEAR(distance(box, at(0, 0, 0), box, at(2, 0.2, 0.1)), 1, kTolerance_m);
  EXPECT_NEAR(distance(box, at(0, 0, 0), box, at(2, 2, 2)), std::sqrt(3), kTolerance_m);
  EXPECT_NEAR(distance(box, at(0, 0, 0), sphere(0.1), at(1, 1, 0)), std::hypot(0.5, 0.5) - 0.1,
              kTolerance_m);
  EXPECT_NEAR(distance(cylinder(0.2, 0.4), at(0, 0, 0), cylinder(0.1, 0.2), at(0, 0.5, 0)), 0.2,
              kTolerance_m);
  EXPECT_NEAR(distance(cylinder(0.2, 0.4), at(0, 0, 0), cylinder(0.1, 0.2), at(0.1, 0, 0.5)), 0.2,
              kTolerance_m);
}

TEST(ConvexShape, AnOverlapIsNegativeAndAtLeastAsDeep) {
  const ConvexShape box = convex_box({1, 1, 1});
  EXPECT_NEAR(distance(box, at(0, 0, 0), box, at(0.9, 0, 0)), -0.1, 1e-9);
  EXPECT_LE(distance(box, at(0, 0, 0), sphere(0.1), at(0.55, 0, 0)), -0.05 + kTolerance_m);
  EXPECT_LE(distance(box, at(0, 0, 0), sphere(0.1), at(0, 0, 0)), -0.6 + kTolerance_m);
  EXPECT_LE(distance(capsule(0.1, 1), at(0, 0, 0), capsule(0.1, 1), at(0.15, 0, 0)),
            -0.05 + kTolerance_m);
  EXPECT_NEAR(distance(cylinder(0.03, 0.01), at(0, 0, 0.003), box, at(0, 0, -0.5)), -0.002, 1e-9);
}

TEST(ConvexShape, AnEarlyEndGivesABoundBelowTheDistance) {
  const ConvexShape box = convex_box({1, 1, 1});
  const double bound = distance_bound(box, at(0, 0, 0), box, at(3, 1, 2), 0.1);
  EXPECT_GT(bound, 0.1);
  EXPECT_LE(bound, distance(box, at(0, 0, 0), box, at(3, 1, 2)) + kTolerance_m);
}

/// Shapes of every kind at random poses.
class RandomShapes {
 public:
  ConvexShape shape() {
    const double a = unit(), b = unit(), c = unit();
    switch (engine_() % 4) {
      case 0:
        return convex_box({0.02 + 0.3 * a, 0.02 + 0.3 * b, 0.02 + 0.3 * c});
      case 1:
        return capsule(0.01 + 0.1 * a, 0.5 * b);
      case 2:
        return cylinder(0.01 + 0.2 * a, 0.01 + 0.4 * b);
      default:
        return sphere(0.01 + 0.2 * a);
    }
  }
  Eigen::Isometry3d pose(double extent) {
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.translation() = extent * Eigen::Vector3d(unit() - 0.5, unit() - 0.5, unit() - 0.5);
    const Eigen::Vector4d q = Eigen::Vector4d(unit(), unit(), unit(), unit()).array() - 0.5;
    X.linear() = Eigen::Quaterniond(q.normalized()).toRotationMatrix();
    return X;
  }
  double unit() { return std::uniform_real_distribution<double>(0, 1)(engine_); }

 private:
  std::mt19937_64 engine_{7};
};

/// Distance of two cores from above, by Frank and Wolfe's method on the difference of the shapes.
double upper_bound(const ConvexShape& a, const Eigen::Isometry3d& X_WA, const ConvexShape& b,
                   const Eigen::Isometry3d& X_WB) {
  Eigen::Vector3d v = X_WA.translation() - X_WB.translation();
  for (int i = 0; i < 4000; ++i) {
    const Eigen::Vector3d pa = X_WA * a.support(X_WA.linear().transpose() * -v);
    const Eigen::Vector3d pb = X_WB * b.support(X_WB.linear().transpose() * v);
    const Eigen::Vector3d w = pa - pb, along = w - v;
    const double length = along.squaredNorm();
    if (length < 1e-24) break;
    v += std::clamp(-v.dot(along) / length, 0.0, 1.0) * along;
  }
  return v.norm() - a.radius_m - b.radius_m;
}

TEST(ConvexShape, TheBoundIsTheDistanceOfRandomShapes) {
  RandomShapes random;
  int apart = 0, overlapping = 0;
  for (int i = 0; i < 3000; ++i) {
    const ConvexShape a = random.shape(), b = random.shape();
    const Eigen::Isometry3d X_WA = random.pose(0.6), X_WB = random.pose(0.6);
    const double bound = distance(a, X_WA, b, X_WB);
    const double above = upper_bound(a, X_WA, b, X_WB);
    EXPECT_LE(bound, above + 1e-9) << i;
    if (above > 1e-2) {
      ++apart;
      EXPECT_NEAR(bound, above, 2e-3) << i;
    }
    if (bound < 0) ++overlapping;
    // It is the same seen from the other side.
    EXPECT_NEAR(bound, distance(b, X_WB, a, X_WA), 2e-5) << i;
  }
  EXPECT_GT(apart, 1000);
  EXPECT_GT(overlapping, 300);
}

TEST(ConvexShape, MovingApartByTheDepthEndsAnOverlap) {
  RandomShapes random;
  int overlapping = 0;
  for (int i = 0; i < 2000; ++i) {
    const ConvexShape a = random.shape(), b = random.shape();
    const Eigen::Isometry3d X_WA = random.pose(0.3), X_WB = random.pose(0.3);
    const double depth = -distance(a, X_WA, b, X_WB);
    if (depth <= 0 || a.radius_m > 0 || b.radius_m > 0) continue;
    ++overlapping;
    // Some direction must be enough: those that the depth is measured along.
    double most = -kFar;
    const auto try_along = [&](const Eigen::Vector3d& direction) {
      for (const double sign : {-1.0, 1.0}) {
        Eigen::Isometry3d moved = X_WB;
        moved.translation() += sign * (depth + 1e-6) * direction;
        most = std::max(most, distance(a, X_WA, b, moved));
      }
    };
    for (int axis = 0; axis < 3; ++axis) {
      try_along(X_WA.linear().col(axis));
      try_along(X_WB.linear().col(axis));
    }
    try_along((X_WB.translation() - X_WA.translation()).normalized());
    EXPECT_GE(most, -kTolerance_m) << i;
  }
  EXPECT_GT(overlapping, 150);
}

}  // namespace
}  // namespace aprsim::robot
