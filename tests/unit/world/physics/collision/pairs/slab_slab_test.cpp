#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/case_count.hpp"
#include "tests/unit/world/physics/collision/solids.hpp"
#include "world/physics/bodies/free_body.hpp"

namespace aprsim::physics {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// A slab with its corners, for the oracles.
struct Slab {
  Vector3d size;
  scene::Outline outline;  ///< about the middle
  bool box = false;

  [[nodiscard]] SlabShape shape() const { return {size, box ? nullptr : &outline}; }
  [[nodiscard]] double distance(const Vector3d& p) const {
    return test::prism_distance(outline.corners, -0.5 * size.z(), 0.5 * size.z(), p);
  }
  [[nodiscard]] double support(const Isometry3d& X_WS, const Vector3d& n) const {
    double most = -1e30;
    for (const Vector2d& c : outline.corners) {
      for (const double z : {-0.5 * size.z(), 0.5 * size.z()}) {
        most = std::max(most, n.dot(X_WS * Vector3d(c.x(), c.y(), z)));
      }
    }
    return most;
  }
};

Slab box_slab(const Vector3d& size, bool box) {
  const Vector2d h = 0.5 * size.head<2>();
  return {size,
          scene::outline_of({{-h.x(), -h.y()}, {h.x(), -h.y()}, {h.x(), h.y()}, {-h.x(), h.y()}}),
          box};
}

/// Corners on an ellipse at random angles: convex.
Slab random_slab(std::mt19937_64& random) {
  const Vector2d radii(test::uniform(random, 0.03, 0.12), test::uniform(random, 0.03, 0.12));
  const int count = 3 + static_cast<int>(test::uniform(random, 0, 21.9));
  std::vector<Vector2d> corners;
  Vector2d half = Vector2d::Zero();
  for (int i = 0; i < count; ++i) {
    const double angle =
        2 * std::numbers::pi * (i + test::uniform(random, -0.3, 0.3)) / static_cast<double>(count);
    corners.emplace_back(radii.x() * std::cos(angle), radii.y() * std::sin(angle));
    half = half.cwiseMax(corners.back().cwiseAbs());
  }
  const double height = test::uniform(random, 0.01, 0.05);
  return {{2 * half.x(), 2 * half.y(), height}, scene::outline_of(corners), false};
}

std::vector<Contact> contacts(const Slab& a, const Isometry3d& X_WA, const Slab& b,
                              const Isometry3d& X_WB) {
  std::vector<Contact> out;
  slab_slab(a.shape(), X_WA, b.shape(), X_WB, 0, 1, SurfacePair::kTrayGround, out);
  return out;
}

/// Least travel that parts two slabs, by a search over directions.
double least_overlap(const Slab& a, const Isometry3d& X_WA, const Slab& b, const Isometry3d& X_WB,
                     std::mt19937_64& random) {
  const auto overlap = [&](const Vector3d& n) { return b.support(X_WB, n) + a.support(X_WA, -n); };
  struct Start {
    double overlap;
    Vector3d n;
  };
  std::vector<Start> starts;
  constexpr int kDirections = 1200, kRefined = 12;
  for (int i = 0; i < kDirections; ++i) {  // Fibonacci sphere
    const double z = 1 - (2 * i + 1.0) / kDirections, r = std::sqrt(1 - z * z), t = 2.39996323 * i;
    const Vector3d n(r * std::cos(t), r * std::sin(t), z);
    starts.push_back({overlap(n), n});
  }
  std::partial_sort(starts.begin(), starts.begin() + kRefined, starts.end(),
                    [](const Start& p, const Start& q) { return p.overlap < q.overlap; });
  double least = 1e30;
  for (std::size_t k = 0; k < kRefined; ++k) {
    Start s = starts[k];
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

double area_of(const std::vector<Vector2d>& corners) {
  double area = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vector2d &p = corners[i], &q = corners[(i + 1) % corners.size()];
    area += (p.x() * q.y() - p.y() * q.x()) / 2;
  }
  return area;
}

TEST(SlabSlab, WithoutOutlinesTheResultIsThatOfBoxes) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 300; ++i) {
    const Slab a = box_slab({0.16, 0.2, 0.015}, true), b = box_slab({0.1, 0.1, 0.05}, true);
    Isometry3d X_WA = test::random_rotation(random);
    for (int k = 0; k < 3; ++k) X_WA.translation()[k] = test::uniform(random, -0.1, 0.1);
    std::vector<Contact> boxes;
    box_box(a.size, X_WA, b.size, Isometry3d::Identity(), 0, 1, SurfacePair::kTrayGround, boxes);
    const auto slabs = contacts(a, X_WA, b, Isometry3d::Identity());
    ASSERT_EQ(slabs.size(), boxes.size());
    for (std::size_t k = 0; k < boxes.size(); ++k) {
      EXPECT_EQ(slabs[k].p_W, boxes[k].p_W);
      EXPECT_EQ(slabs[k].n_W, boxes[k].n_W);
      EXPECT_EQ(slabs[k].depth_m, boxes[k].depth_m);
    }
  }
}

// A rectangle as a polygon finds what a box does, up to rounding, and up to the choice of points
// where there are more than four.
TEST(SlabSlab, ARectangularOutlineIsABox) {
  std::mt19937_64 random(5);
  int touching = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vector3d size_a(0.16, 0.2, 0.015), size_b(0.1, 0.1, 0.05);
    Isometry3d X_WA = test::random_rotation(random);
    for (int k = 0; k < 3; ++k) X_WA.translation()[k] = test::uniform(random, -0.12, 0.12);
    const auto of_boxes =
        contacts(box_slab(size_a, true), X_WA, box_slab(size_b, true), Isometry3d::Identity());
    const auto of_prisms =
        contacts(box_slab(size_a, false), X_WA, box_slab(size_b, false), Isometry3d::Identity());
    ASSERT_EQ(of_prisms.empty(), of_boxes.empty()) << i;
    if (of_boxes.empty()) continue;
    ++touching;
    EXPECT_NEAR(test::deepest(of_prisms), test::deepest(of_boxes), 1e-9) << i;
    EXPECT_LT((of_prisms[0].n_W - of_boxes[0].n_W).norm(), 1e-9) << i;
    if (of_prisms.size() <= 4) {
      EXPECT_EQ(of_prisms.size(), of_boxes.size()) << i;
    }
  }
  EXPECT_GT(touching, 300);
}

TEST(SlabSlab, ATrayOnATableRestsOnNearlyAllOfItsOutline) {
  std::mt19937_64 random(9);
  const Slab table = box_slab({2, 2, 0.1}, true);
  for (int i = 0; i < 50; ++i) {
    const Slab tray = random_slab(random);
    const Isometry3d X_WA = test::pose(0.2, -0.1, 0.5 * tray.size.z() - 1e-5) *
                            Eigen::AngleAxisd(0.3 * i, Vector3d::UnitZ());
    const auto found = contacts(tray, X_WA, table, test::pose(0, 0, -0.05));
    ASSERT_EQ(found.size(), std::min<std::size_t>(8, tray.outline.corners.size()));
    std::vector<Vector2d> held;
    for (const Contact& c : found) {
      EXPECT_NEAR(c.depth_m, 1e-5, 1e-12);
      EXPECT_TRUE(c.n_W.isApprox(Vector3d::UnitZ(), 1e-12));
      EXPECT_NEAR(tray.distance(X_WA.inverse() * c.p_W), 0, 1e-12);
      held.push_back((X_WA.inverse() * c.p_W).head<2>());
    }
    std::sort(held.begin(), held.end(), [](const Vector2d& p, const Vector2d& q) {
      return std::atan2(p.y(), p.x()) < std::atan2(q.y(), q.x());
    });
    EXPECT_GT(area_of(held), 0.88 * area_of(tray.outline.corners));
  }
}

TEST(SlabSlab, AWedgeIsHeldByItsSideNotByTheBoxAroundIt) {
  const scene::TrayType type = test::wedge_tray();
  const Vector2d middle = 0.5 * (type.min_xy + type.max_xy);
  const Vector3d size(type.max_xy.x() - type.min_xy.x(), type.max_xy.y() - type.min_xy.y(), 0.015);
  const SlabShape wedge{size, &*type.outline, middle};
  const Isometry3d X_WP = test::pose(0, 0, 0),
                   X_WS = X_WP * Eigen::Translation3d(middle.x(), middle.y(), -0.0075);
  // A finger beside the corner that the outline cuts off.
  const Vector3d finger(0.01, 0.01, 0.04);
  std::vector<Contact> out;
  slab_slab({finger}, test::pose(0.079, -0.079, 0), wedge, X_WS, 0, 1, SurfacePair::kRobotAny, out);
  EXPECT_TRUE(out.empty());
  box_box(finger, test::pose(0.079, -0.079, 0), size, X_WS, 0, 1, SurfacePair::kRobotAny, out);
  EXPECT_FALSE(out.empty());
  out.clear();
  slab_slab({finger}, test::pose(0.0759, -0.0759, 0), wedge, X_WS, 0, 1, SurfacePair::kRobotAny,
            out);
  ASSERT_FALSE(out.empty());
  const Vector3d outward = Vector3d(1, -1, 0).normalized();
  EXPECT_TRUE(out[0].n_W.isApprox(outward, 1e-9));
  // The finger's near corner lies behind the line from (60, -85) to (85, -60) mm.
  EXPECT_NEAR(test::deepest(out), (0.145 - 2 * 0.0709) / std::numbers::sqrt2, 1e-9);
}

TEST(SlabSlab, RandomPosesAgreeWithASearchOverDirections) {
  std::mt19937_64 random(7);
  int touching = 0;
  const int cases = aprsim::test::case_count(500);
  for (int i = 0; i < cases; ++i) {
    const Slab a = random_slab(random);
    const Slab b =
        i % 2 ? random_slab(random)
              : box_slab({test::uniform(random, 0.02, 0.2), test::uniform(random, 0.02, 0.2),
                          test::uniform(random, 0.01, 0.1)},
                         true);
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
    EXPECT_LE(found.size(), 8U);
    const double depth = test::deepest(found);
    // A face may be preferred to a direction that is up to 5 % shallower.
    EXPECT_LE(depth, expected / 0.93 + 1e-6) << i;
    EXPECT_GE(depth, 0.5 * expected) << i;
    for (const Contact& c : found) {
      EXPECT_LE(a.distance(X_WA.inverse() * c.p_W), 1e-9) << i;
      EXPECT_LE(b.distance(X_WB.inverse() * c.p_W), 1e-9) << i;
    }
    // Pushed out along its normal, nothing is left.
    const Contact& deepest =
        *std::max_element(found.begin(), found.end(),
                          [](const Contact& p, const Contact& q) { return p.depth_m < q.depth_m; });
    X_WA.translation() += deepest.n_W * (expected / 0.93 + 1e-6);
    EXPECT_LE(test::deepest(contacts(a, X_WA, b, X_WB)), 0.1 * expected + 1e-6) << i;
  }
  EXPECT_GT(touching, 3 * cases / 10);
}

/// Two random slabs and their poses, which overlap by less than a millimetre.
struct TouchingPair {
  Slab a, b;
  Isometry3d X_WA, X_WB;
};

TouchingPair random_touching(std::mt19937_64& random) {
  for (;;) {
    TouchingPair pair{random_slab(random), random_slab(random), test::random_rotation(random),
                      test::random_rotation(random)};
    for (int k = 0; k < 3; ++k) pair.X_WA.translation()[k] = test::uniform(random, -0.12, 0.12);
    for (int tries = 0; tries < 5; ++tries) {
      const auto found = contacts(pair.a, pair.X_WA, pair.b, pair.X_WB);
      if (found.empty()) break;
      const double depth = test::deepest(found);
      if (depth < 1e-3) return pair;
      pair.X_WA.translation() += found[0].n_W * (depth - test::uniform(random, 1e-5, 9e-4));
    }
  }
}

constexpr double kRounding = 1e-9;

TEST(SlabSlab, ATurnedPairHasItsContactsTurned) {
  std::mt19937_64 random(17);
  for (int i = 0; i < 1000; ++i) {
    const TouchingPair pair = random_touching(random);
    Isometry3d X = test::random_rotation(random);
    X.translation() = Vector3d(1, -2, 0.5);
    const auto found = contacts(pair.a, pair.X_WA, pair.b, pair.X_WB);
    const auto turned = contacts(pair.a, X * pair.X_WA, pair.b, X * pair.X_WB);
    ASSERT_EQ(turned.size(), found.size()) << i;
    for (std::size_t k = 0; k < found.size(); ++k) {
      EXPECT_LT((turned[k].p_W - X * found[k].p_W).norm(), kRounding) << i;
      EXPECT_LT((turned[k].n_W - X.linear() * found[k].n_W).norm(), kRounding) << i;
      EXPECT_NEAR(turned[k].depth_m, found[k].depth_m, kRounding) << i;
    }
  }
}

/// The mirror image in the plane y = 0 of its frame, as a shape and as a pose.
Slab mirrored(const Slab& slab) {
  std::vector<Vector2d> corners;
  for (const Vector2d& c : slab.outline.corners) corners.emplace_back(c.x(), -c.y());
  std::reverse(corners.begin(), corners.end());
  return {slab.size, scene::outline_of(corners), slab.box};
}
Isometry3d mirrored(const Isometry3d& X) {
  const Eigen::DiagonalMatrix<double, 3> M(1, -1, 1);
  Isometry3d out = Isometry3d::Identity();
  out.linear() = M * X.linear() * M;
  out.translation() = M * X.translation();
  return out;
}

// The choice of points follows the order of the corners, which turns round in a mirror.
TEST(SlabSlab, AMirroredPairIsAsDeepAlongTheMirroredNormal) {
  std::mt19937_64 random(19);
  for (int i = 0; i < 1000; ++i) {
    const TouchingPair pair = random_touching(random);
    const auto found = contacts(pair.a, pair.X_WA, pair.b, pair.X_WB);
    const auto image =
        contacts(mirrored(pair.a), mirrored(pair.X_WA), mirrored(pair.b), mirrored(pair.X_WB));
    ASSERT_FALSE(image.empty()) << i;
    EXPECT_NEAR(test::deepest(image), test::deepest(found), kRounding) << i;
    const Vector3d n = found[0].n_W.cwiseProduct(Vector3d(1, -1, 1));
    EXPECT_LT((image[0].n_W - n).norm(), kRounding) << i;
  }
}

TEST(SlabSlab, TheCornerAtWhichTheListBeginsIsOfNoMatter) {
  std::mt19937_64 random(23);
  for (int i = 0; i < 1000; ++i) {
    TouchingPair pair = random_touching(random);
    const auto found = contacts(pair.a, pair.X_WA, pair.b, pair.X_WB);
    std::vector<Vector2d> corners = pair.a.outline.corners;
    std::rotate(corners.begin(), corners.begin() + 1, corners.end());
    pair.a.outline = scene::outline_of(corners);
    const auto again = contacts(pair.a, pair.X_WA, pair.b, pair.X_WB);
    ASSERT_FALSE(again.empty()) << i;
    EXPECT_NEAR(test::deepest(again), test::deepest(found), kRounding) << i;
    EXPECT_LT((again[0].n_W - found[0].n_W).norm(), kRounding) << i;
  }
}

TEST(SlabSlab, InTheOtherOrderTheNormalIsReversed) {
  std::mt19937_64 random(29);
  int same = 0;
  constexpr int kPairs = 1000;
  for (int i = 0; i < kPairs; ++i) {
    const TouchingPair pair = random_touching(random);
    const auto found = contacts(pair.a, pair.X_WA, pair.b, pair.X_WB);
    const auto swapped = contacts(pair.b, pair.X_WB, pair.a, pair.X_WA);
    ASSERT_FALSE(swapped.empty()) << i;
    // The first slab's face is preferred among directions that are nearly as deep.
    if ((swapped[0].n_W + found[0].n_W).norm() > 1e-6) continue;
    ++same;
    EXPECT_NEAR(test::deepest(swapped), test::deepest(found), kRounding) << i;
  }
  EXPECT_GT(same, 0.95 * kPairs);
}

TEST(SlabSlab, CapsulesAreAsDeepAsTheirSamples) {
  std::mt19937_64 random(13);
  int touching = 0, outside = 0;
  for (int i = 0; i < 600; ++i) {
    const Slab slab = random_slab(random);
    const double radius = test::uniform(random, 0.01, 0.05);
    const double length = i % 3 ? test::uniform(random, 0.02, 0.2) : 0;
    Isometry3d X_WS = test::random_rotation(random), X_WC = test::random_rotation(random);
    for (int k = 0; k < 3; ++k) X_WC.translation()[k] = test::uniform(random, -0.12, 0.12);
    const Isometry3d X_SC = X_WS.inverse() * X_WC;
    double nearest = 1e30;
    constexpr int kSamples = 2000;
    for (int k = 0; k <= kSamples; ++k) {
      const double z = length * (k / double{kSamples} - 0.5);
      nearest = std::min(nearest, slab.distance(X_SC * Vector3d(0, 0, z)));
    }
    std::vector<Contact> found;
    slab_capsule(slab.shape(), X_WS, radius, length, X_WC, 0, 1, SurfacePair::kRobotAny, found);
    const double expected = radius - nearest;
    if (expected < -1e-9) {
      EXPECT_TRUE(found.empty()) << i;
      continue;
    }
    ++touching;
    ASSERT_FALSE(found.empty()) << i;
    // Where the axis itself is inside, its deepest point may have an exit right through the slab.
    if (nearest > 0) {
      ++outside;
      EXPECT_GE(test::deepest(found), expected - 1e-7) << i;
      EXPECT_LE(test::deepest(found), expected + 0.5 * length / kSamples + 1e-12) << i;
    }
    for (const Contact& c : found) {
      // Moved by its depth along the normal the point is free of the slab.
      const Vector3d out = c.p_W - c.depth_m * c.n_W;
      EXPECT_GE(slab.distance(X_WS.inverse() * out), -1e-9) << i;
    }
  }
  EXPECT_GT(touching, 150);
  EXPECT_GT(outside, 50);
}

TEST(SlabSlab, ACylinderTouchesASlabAsAGearDoes) {
  std::mt19937_64 random(15);
  int touching = 0;
  for (int i = 0; i < 600; ++i) {
    const Slab slab = random_slab(random);
    const double radius = test::uniform(random, 0.02, 0.06);
    const double length = test::uniform(random, 0.02, 0.1);
    Isometry3d X_WC = test::random_rotation(random);
    for (int k = 0; k < 3; ++k) X_WC.translation()[k] = test::uniform(random, -0.1, 0.1);
    std::vector<Contact> found;
    slab_cylinder(slab.shape(), Isometry3d::Identity(), radius, length, X_WC, 0, 1,
                  SurfacePair::kRobotAny, found);
    const auto in_cylinder = [&](const Vector3d& p_W) {
      const Vector3d p = X_WC.inverse() * p_W;
      return std::max(p.head<2>().norm() - radius, std::abs(p.z()) - 0.5 * length);
    };
    // Corners of the slab in the cylinder, and its rims in the slab.
    double sampled = 0;
    constexpr int kAround = 360;
    for (int k = 0; k < kAround; ++k) {
      const double angle = 2 * std::numbers::pi * k / kAround;
      for (const double z : {-0.5 * length, 0.5 * length}) {
        const Vector3d rim(radius * std::cos(angle), radius * std::sin(angle), z);
        sampled = std::max(sampled, -slab.distance(X_WC * rim));
      }
    }
    for (const Vector2d& c : slab.outline.corners) {
      for (const double z : {-0.5 * slab.size.z(), 0.5 * slab.size.z()}) {
        sampled = std::max(sampled, -in_cylinder({c.x(), c.y(), z}));
      }
    }
    if (sampled > 1e-5) {
      ++touching;
      EXPECT_FALSE(found.empty()) << i;
    }
    if (sampled > 1e-5 && sampled < 1e-3) {
      EXPECT_GE(test::deepest(found), 0.9 * sampled - 2e-6) << i;
    }
    for (const Contact& c : found) {
      EXPECT_LE(slab.distance(c.p_W), 1e-9) << i;
      EXPECT_LE(in_cylinder(c.p_W), 1e-9) << i;
    }
  }
  EXPECT_GT(touching, 150);
}

}  // namespace
}  // namespace aprsim::physics
