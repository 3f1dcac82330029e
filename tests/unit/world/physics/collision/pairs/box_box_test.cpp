#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/world/physics/collision/solids.hpp"

namespace aprsim::physics {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

std::vector<Contact> contacts(const Vector3d& a, const Isometry3d& X_WA, const Vector3d& b,
                              const Isometry3d& X_WB) {
  std::vector<Contact> out;
  box_box(a, X_WA, b, X_WB, 0, 1, SurfacePair::kTrayGround, out);
  return out;
}

TEST(BoxBox, ASlabOnATableRestsOnItsFourCorners) {
  const Vector3d slab(0.16, 0.2, 0.015), table(2, 1, 0.1);
  const Isometry3d X_WA =
      test::pose(0.1, 0.2, 0.0075 - 1e-5) * Eigen::AngleAxisd(0.4, Vector3d::UnitZ());
  const auto found = contacts(slab, X_WA, table, test::pose(0, 0, -0.05));
  ASSERT_EQ(found.size(), 4U);
  for (const Contact& c : found) {
    EXPECT_NEAR(c.depth_m, 1e-5, 1e-12);
    EXPECT_TRUE(c.n_W.isApprox(Vector3d::UnitZ(), 1e-12));
    const Vector3d p = X_WA.inverse() * c.p_W;
    EXPECT_NEAR(std::abs(p.x()), 0.08, 1e-9);
    EXPECT_NEAR(std::abs(p.y()), 0.1, 1e-9);
  }
}

TEST(BoxBox, TheNormalPointsFromTheSecondIntoTheFirst) {
  const Vector3d cube(0.1, 0.1, 0.1);
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      const Vector3d at = sign * 0.0999 * Vector3d::Unit(axis);
      const auto found =
          contacts(cube, test::pose(at.x(), at.y(), at.z()), cube, Isometry3d::Identity());
      ASSERT_EQ(found.size(), 4U);
      for (const Contact& c : found) {
        EXPECT_TRUE(c.n_W.isApprox(sign * Vector3d::Unit(axis), 1e-12));
        EXPECT_NEAR(c.depth_m, 1e-4, 1e-12);
      }
    }
  }
}

TEST(BoxBox, ASlabOverATablesEdgeIsSupportedUpToTheEdge) {
  const Vector3d slab(0.2, 0.1, 0.015), table(1, 1, 0.1);
  const auto found =
      contacts(slab, test::pose(0.55, 0, 0.0075 - 1e-5), table, test::pose(0, 0, -0.05));
  ASSERT_EQ(found.size(), 4U);
  double most = 0, least = 1;
  for (const Contact& c : found) {
    most = std::max(most, c.p_W.x());
    least = std::min(least, c.p_W.x());
  }
  EXPECT_NEAR(most, 0.5, 1e-12);
  EXPECT_NEAR(least, 0.45, 1e-12);
}

TEST(BoxBox, ATiltedSlabTouchesWithItsLowestEdgeOrCorner) {
  const Vector3d slab(0.2, 0.1, 0.015), table(1, 1, 0.1);
  Isometry3d X = test::tilted(0, 0, 0, 0.02, 0);  // about x: one long edge low
  const auto lowest = [&](const Isometry3d& pose) {
    double z = 1;
    for (const Vector3d& p : test::box_edges(slab, 1)) z = std::min(z, (pose * p).z());
    return z;
  };
  X.translation().z() -= lowest(X) + 1e-5;
  auto found = contacts(slab, X, table, test::pose(0, 0, -0.05));
  ASSERT_EQ(found.size(), 2U);
  EXPECT_NEAR(test::deepest(found), 1e-5, 1e-12);
  X = test::tilted(0, 0, 0, 0.02, 0.7);
  X.translation().z() -= lowest(X) + 1e-5;
  found = contacts(slab, X, table, test::pose(0, 0, -0.05));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(test::deepest(found), 1e-5, 1e-12);
}

TEST(BoxBox, CrossedEdgesTouchInOnePoint) {
  const Vector3d cube(0.1, 0.1, 0.1);
  const double half_diagonal = 0.05 * std::numbers::sqrt2;
  const Isometry3d X_WB(Eigen::AngleAxisd(std::numbers::pi / 4, Vector3d::UnitX()));
  const Isometry3d X_WA = test::pose(0.01, -0.02, 2 * half_diagonal - 1e-4) *
                          Eigen::AngleAxisd(std::numbers::pi / 4, Vector3d::UnitY());
  const auto found = contacts(cube, X_WA, cube, X_WB);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(found[0].depth_m, 1e-4, 1e-12);
  EXPECT_TRUE(found[0].n_W.isApprox(Vector3d::UnitZ(), 1e-12));
  EXPECT_LT((found[0].p_W - Vector3d(0.01, 0, half_diagonal - 5e-5)).norm(), 0.02 + 1e-9);
  EXPECT_NEAR(found[0].p_W.z(), half_diagonal - 5e-5, 1e-12);
}

/// Least overlap over all directions, found by search rather than by the separating-axis theorem.
double least_overlap(const Vector3d& a, const Isometry3d& X_WA, const Vector3d& b,
                     const Isometry3d& X_WB, std::mt19937_64& random) {
  const Vector3d d = X_WA.translation() - X_WB.translation();
  const auto overlap = [&](const Vector3d& n) {
    return 0.5 * a.dot((X_WA.linear().transpose() * n).cwiseAbs()) +
           0.5 * b.dot((X_WB.linear().transpose() * n).cwiseAbs()) - std::abs(n.dot(d));
  };
  struct Start {
    double overlap;
    Vector3d n;
  };
  std::vector<Start> starts;
  constexpr int kDirections = 600, kRefined = 12;
  for (int i = 0; i < kDirections; ++i) {  // half a Fibonacci sphere
    const double z = (i + 0.5) / kDirections, r = std::sqrt(1 - z * z), t = 2.39996323 * i;
    const Vector3d n(r * std::cos(t), r * std::sin(t), z);
    starts.push_back({overlap(n), n});
  }
  std::partial_sort(starts.begin(), starts.begin() + kRefined, starts.end(),
                    [](const Start& p, const Start& q) { return p.overlap < q.overlap; });
  double least = 1e30;
  for (int k = 0; k < kRefined; ++k) {
    Start s = starts[static_cast<std::size_t>(k)];
    for (double step = 0.1; step > 1e-6; step *= 0.985) {
      const Vector3d jump(test::uniform(random, -1, 1), test::uniform(random, -1, 1),
                          test::uniform(random, -1, 1));
      const Vector3d n = (s.n + step * jump).normalized();
      if (overlap(n) < s.overlap) s = {overlap(n), n};
    }
    least = std::min(least, s.overlap);
  }
  return least;
}

TEST(BoxBox, RandomPosesAgreeWithASearchOverDirections) {
  std::mt19937_64 random(7);
  int touching = 0;
  for (int i = 0; i < 800; ++i) {
    const auto size = [&] {
      return Vector3d(test::uniform(random, 0.02, 0.2), test::uniform(random, 0.02, 0.2),
                      test::uniform(random, 0.01, 0.1));
    };
    const Vector3d a = size(), b = size();
    Isometry3d X_WA = test::random_rotation(random), X_WB = test::random_rotation(random);
    for (int k = 0; k < 3; ++k) X_WA.translation()[k] = test::uniform(random, -0.12, 0.12);
    double expected = least_overlap(a, X_WA, b, X_WB, random);
    if (expected > 1e-3) {  // moved out until the overlap is shallow
      const auto deep = contacts(a, X_WA, b, X_WB);
      ASSERT_FALSE(deep.empty()) << i;
      X_WA.translation() += deep[0].n_W * (expected - test::uniform(random, 1e-5, 1e-3));
      expected = least_overlap(a, X_WA, b, X_WB, random);
    }
    const auto found = contacts(a, X_WA, b, X_WB);
    if (expected < -1e-6) {
      EXPECT_TRUE(found.empty()) << i;
      continue;
    }
    if (expected < 1e-5) continue;
    ++touching;
    ASSERT_FALSE(found.empty()) << i;
    EXPECT_LE(found.size(), 4U);
    const double depth = test::deepest(found);
    // A face may be preferred to a direction that is up to 5 % shallower.
    EXPECT_LE(depth, expected / 0.93 + 1e-6) << i;
    EXPECT_GE(depth, 0.5 * expected) << i;
    for (const Contact& c : found) {
      EXPECT_LE(test::box_distance(0.5 * a, X_WA.inverse() * c.p_W), 1e-9) << i;
      EXPECT_LE(test::box_distance(0.5 * b, X_WB.inverse() * c.p_W), 1e-9) << i;
    }
    // Pushed out along its normals, nothing is left.
    const Contact& deepest =
        *std::max_element(found.begin(), found.end(),
                          [](const Contact& p, const Contact& q) { return p.depth_m < q.depth_m; });
    X_WA.translation() += deepest.n_W * (expected / 0.93 + 1e-6);
    EXPECT_LE(test::deepest(contacts(a, X_WA, b, X_WB)), 0.1 * expected + 1e-6) << i;
  }
  EXPECT_GT(touching, 200);
}

}  // namespace
}  // namespace aprsim::physics
