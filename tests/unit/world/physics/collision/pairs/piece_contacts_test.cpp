#include "world/physics/collision/pairs/piece_contacts.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/world/physics/collision/solids.hpp"
#include "tests/unit/world/physics/random_part.hpp"
#include "world/physics/collision/pairs/narrow_phase.hpp"
#include "world/physics/collision/pairs/polytope_contacts.hpp"
#include "world/physics/collision/speculative/ray_gap.hpp"
#include "world/scene/model/pieces.hpp"

namespace aprsim::physics {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using test::PieceShape;

constexpr double kRadius_m = 0.03;

Isometry3d random_pose(std::mt19937_64& random, double apart_m) {
  Isometry3d X = test::random_rotation(random);
  const Vector3d direction = test::random_rotation(random).linear().col(0);
  X.translation() = apart_m * direction;
  return X;
}

api::Piece any_piece(std::mt19937_64& random) {
  const auto number = std::uniform_int_distribution<int>(0, test::kPieceShapes - 1)(random);
  return test::random_piece(static_cast<PieceShape>(number), kRadius_m, random);
}

std::vector<Contact> contacts_of(const ConvexPiece& a, const Isometry3d& X_WA, const ConvexPiece& b,
                                 const Isometry3d& X_WB) {
  std::vector<Contact> out;
  shape_on_shape(a.shape(), X_WA, b.shape(), X_WB, {1, 0, SurfacePair::kPart}, out);
  return out;
}

/// Least travel of a along n that leaves b, by the pieces' own support points.
double overlap_along(const api::Piece& a, const Isometry3d& X_WA, const api::Piece& b,
                     const Isometry3d& X_WB, const Vector3d& n) {
  const auto support = [](const api::Piece& piece, const Isometry3d& X, const Vector3d& d) {
    return X * scene::support_of(piece, X.linear().transpose() * d);
  };
  return n.dot(support(b, X_WB, n) - support(a, X_WA, -n));
}

/// The least over all directions: a search from many of them.
double least_overlap(const api::Piece& a, const Isometry3d& X_WA, const api::Piece& b,
                     const Isometry3d& X_WB, std::mt19937_64& random) {
  struct Start {
    double overlap;
    Vector3d n;
  };
  std::vector<Start> starts;
  constexpr int kDirections = 600;
  for (int i = 0; i < kDirections; ++i) {  // Fibonacci sphere
    const double z = 1 - 2 * (i + 0.5) / kDirections,
                 turn = i * std::numbers::pi * (3 - std::sqrt(5.0));
    const double r = std::sqrt(1 - z * z);
    const Vector3d n(r * std::cos(turn), r * std::sin(turn), z);
    starts.push_back({overlap_along(a, X_WA, b, X_WB, n), n});
  }
  std::ranges::sort(starts, {}, &Start::overlap);
  std::normal_distribution<double> normal;
  double best = 1e30;
  for (std::size_t s = 0; s < 6; ++s) {
    Start at = starts[s];
    double width = 0.1;
    for (int i = 0; i < 1500; ++i) {
      const Vector3d n =
          (at.n + width * Vector3d(normal(random), normal(random), normal(random))).normalized();
      const double overlap = overlap_along(a, X_WA, b, X_WB, n);
      if (overlap < at.overlap) {
        at = {overlap, n};
      } else {
        width = std::max(1e-9, 0.985 * width);
      }
    }
    best = std::min(best, at.overlap);
  }
  return best;
}

// A shallow penetration of every pair of kinds: the deepest contact is the least translation, whose
// direction parts the two.
TEST(PieceContacts, RandomDepthIsTheLeastTranslation) {
  std::mt19937_64 random(11);
  int compared = 0;
  for (int i = 0; i < 600; ++i) {
    const api::Piece a = any_piece(random), b = any_piece(random);
    const ConvexPiece piece_a(a), piece_b(b);
    const Isometry3d X_WB = Isometry3d::Identity();
    Isometry3d X_WA = random_pose(random, 2 * kRadius_m);
    // Moved together until they touch, the last step by bisection, and then a little on.
    const Vector3d towards = -X_WA.translation().normalized();
    const auto at = [&](double way) {
      Isometry3d X = X_WA;
      X.translation() += way * towards;
      return X;
    };
    const auto touches = [&](double way) {
      return !contacts_of(piece_a, at(way) * piece_a.X_BP(), piece_b, X_WB * piece_b.X_BP())
                  .empty();
    };
    constexpr double kStep_m = 2e-4;
    double inside = 0;
    while (inside < 2 * kRadius_m && !touches(inside)) inside += kStep_m;
    double apart = inside - kStep_m;
    for (int k = 0; k < 40; ++k) {
      const double middle = 0.5 * (apart + inside);
      (touches(middle) ? inside : apart) = middle;
    }
    const std::string kinds = std::to_string(i) + ": " + std::to_string(a.shape.index()) + " on " +
                              std::to_string(b.shape.index());
    // Where contacts begin the shapes touch: nothing is missed before. The search for the least way
    // out is coarse across edges of polyhedra.
    const auto is_flat = [](const api::Piece& piece) {
      return !std::holds_alternative<api::ConePiece>(piece.shape) &&
             !std::holds_alternative<api::CapsulePiece>(piece.shape);
    };
    const double late = least_overlap(a, at(inside), b, X_WB, random);
    EXPECT_LT(late, is_flat(a) || is_flat(b) ? 1.5e-4 : 1e-5) << kinds;
    const double into = test::uniform(random, 1e-6, 2e-4);
    X_WA = at(inside + into);
    const auto found = contacts_of(piece_a, X_WA * piece_a.X_BP(), piece_b, X_WB * piece_b.X_BP());
    if (found.empty()) continue;  // it only grazed the other one
    const Contact& deepest = *std::ranges::max_element(found, {}, &Contact::depth_m);
    const double least = least_overlap(a, X_WA, b, X_WB, random);
    // No contact is deeper than the way along it, and the deepest is most of the least way out.
    for (const Contact& contact : found) {
      EXPECT_LT(contact.depth_m, overlap_along(a, X_WA, b, X_WB, contact.n_W) + 1e-9) << kinds;
    }
    EXPECT_GT(deepest.depth_m, 0.3 * (least - late) - 1e-6) << kinds;
    ++compared;
  }
  EXPECT_GT(compared, 500);
}

/// The same solid as a hull.
ConvexPiece as_hull(const Vector3d& size) {
  std::vector<Vector3d> corners;
  for (const double x : {-0.5, 0.5}) {
    for (const double y : {-0.5, 0.5}) {
      for (const double z : {-0.5, 0.5}) corners.push_back(Vector3d(x, y, z).cwiseProduct(size));
    }
  }
  return ConvexPiece({scene::hull_of(corners), {}});
}

/// Depth and normal of the deepest contact of both lists are the same.
int other_choices = 0;
void expect_same_deepest(const std::vector<Contact>& exact, const std::vector<Contact>& general,
                         double tolerance_m, int i) {
  ASSERT_EQ(exact.empty(), general.empty()) << i;
  if (exact.empty()) return;
  const Contact& a = *std::ranges::max_element(exact, {}, &Contact::depth_m);
  const Contact& b = *std::ranges::max_element(general, {}, &Contact::depth_m);
  // Where a face and two edges are as near, the methods may choose differently.
  if (std::abs(a.depth_m - b.depth_m) > tolerance_m) {
    EXPECT_NEAR(a.depth_m, b.depth_m, 0.35 * a.depth_m) << i;
    ++other_choices;
    return;
  }
  const bool same = std::ranges::any_of(exact, [&](const Contact& contact) {
    return contact.n_W.dot(b.n_W) > 1 - 1e-9 || contact.depth_m < 0.98 * a.depth_m;
  });
  EXPECT_TRUE(same) << i;
}

/// The first pose along a way in which they penetrate by less than 0.3 mm.
template <class Depth>
Isometry3d shallow_pose(const Isometry3d& X, const Vector3d& towards, const Depth& depth) {
  Isometry3d at = X;
  for (int k = 0; k < 2000 && depth(at) <= 0; ++k) at.translation() += 1e-4 * towards;
  return at;
}

TEST(PieceContacts, RandomHullsAreAsTheirBoxes) {
  other_choices = 0;
  std::mt19937_64 random(3);
  for (int i = 0; i < 2000; ++i) {
    const Vector3d size_a(test::uniform(random, 0.01, 0.06), test::uniform(random, 0.01, 0.06),
                          test::uniform(random, 0.01, 0.06));
    const Vector3d size_b(test::uniform(random, 0.01, 0.06), test::uniform(random, 0.01, 0.06),
                          test::uniform(random, 0.01, 0.06));
    const Isometry3d X_WB = test::random_rotation(random);
    const auto exact = [&](const Isometry3d& X_WA) {
      std::vector<Contact> out;
      box_box(size_a, X_WA, size_b, X_WB, 1, 0, SurfacePair::kPart, out);
      return out;
    };
    const Isometry3d start = random_pose(random, 0.12);
    const Isometry3d X_WA =
        shallow_pose(start, -start.translation().normalized(),
                     [&](const Isometry3d& X) { return test::deepest(exact(X)); });
    expect_same_deepest(exact(X_WA), contacts_of(as_hull(size_a), X_WA, as_hull(size_b), X_WB),
                        1e-12, i);
  }
  EXPECT_LT(other_choices, 4);
}

TEST(PieceContacts, RandomCylindersOnHullsAreAsOnBoxes) {
  other_choices = 0;
  std::mt19937_64 random(4);
  for (int i = 0; i < 2000; ++i) {
    const Vector3d size(test::uniform(random, 0.01, 0.06), test::uniform(random, 0.01, 0.06),
                        test::uniform(random, 0.01, 0.06));
    const ConvexPiece round(test::random_piece(
        i % 2 == 0 ? PieceShape::kCylinder : PieceShape::kCone, kRadius_m, random));
    const Isometry3d X_WB = test::random_rotation(random);
    const auto exact = [&](const Isometry3d& X_WA) {
      std::vector<Contact> out;
      gear_box(*round.shape().round, X_WA, size, X_WB, 1, 0, SurfacePair::kPart, out);
      return out;
    };
    const Isometry3d start = random_pose(random, 0.12);
    const Isometry3d X_WA =
        shallow_pose(start, -start.translation().normalized(),
                     [&](const Isometry3d& X) { return test::deepest(exact(X)); });
    expect_same_deepest(exact(X_WA), contacts_of(round, X_WA, as_hull(size), X_WB), 1e-8, i);
  }
  EXPECT_LT(other_choices, 4);
}

// A ball's depth is its radius less the distance of its centre from the other shape.
TEST(PieceContacts, RandomBallsAreAsNearAsTheirCentres) {
  std::mt19937_64 random(5);
  for (int i = 0; i < 5000; ++i) {
    const double r = test::uniform(random, 0.005, 0.03);
    const ConvexPiece ball({api::CapsulePiece{r, 0}, {}});
    const Vector3d half(test::uniform(random, 0.01, 0.04), test::uniform(random, 0.01, 0.04),
                        test::uniform(random, 0.01, 0.04));
    const auto corners = test::regular_polygon(3 + i % 9, test::uniform(random, 0.02, 0.05));
    const bool as_box = i % 2 == 0;
    const ConvexPiece other = as_box ? ConvexPiece({api::BoxPiece{2 * half}, {}})
                                     : ConvexPiece({api::PrismPiece{corners, 2 * half.z()}, {}});
    const Isometry3d X_WB = test::random_rotation(random);
    const Isometry3d X_WA = random_pose(random, test::uniform(random, 0.02, 0.09));
    const Vector3d p = X_WB.inverse() * X_WA.translation();
    const double distance =
        as_box ? test::box_distance(half, p)
               : test::prism_distance(corners, -half.z(), half.z(), p + other.X_BP().translation());
    const auto found = contacts_of(ball, X_WA, other, X_WB * Isometry3d::Identity());
    if (distance > r + 1e-9) {
      EXPECT_TRUE(found.empty()) << i;
    } else if (distance < r - 1e-9 && distance > 1e-6) {
      ASSERT_EQ(found.size(), 1u) << i;
      EXPECT_NEAR(found[0].depth_m, r - distance, 1e-12) << i;
    }
  }
}

// A capsule that lies on a box is held at both ends, also where the box ends before it.
TEST(PieceContacts, ACapsuleIsHeldAtBothEnds) {
  const ConvexPiece capsule({api::CapsulePiece{0.01, 0.08}, {}});
  Isometry3d lying(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3d::UnitY()));
  lying.translation().z() = 0.02 - 1e-6;
  for (const double length : {0.2, 0.05}) {
    const ConvexPiece box({api::BoxPiece{{length, 0.1, 0.02}}, {}});
    const auto found = contacts_of(capsule, lying, box, Isometry3d::Identity());
    ASSERT_EQ(found.size(), 2u);
    const double end = std::min(0.04, 0.5 * length);
    EXPECT_NEAR(std::abs(found[0].p_W.x()), end, 1e-5);
    EXPECT_NEAR(found[0].p_W.x(), -found[1].p_W.x(), 1e-5);
    EXPECT_NEAR(found[0].depth_m, 1e-6, 2e-9);
  }
}

// The disc of a gear on a hull is held on its true rim.
TEST(PieceContacts, ACylinderStandsOnItsRim) {
  const ConvexPiece cylinder({api::ConePiece{0.02, 0.02, 0.03}, {}});
  const ConvexPiece plate = as_hull({0.2, 0.2, 0.02});
  Isometry3d standing = Isometry3d::Identity();
  standing.translation().z() = 0.025 - 1e-6;
  const auto found = contacts_of(cylinder, standing, plate, Isometry3d::Identity());
  ASSERT_EQ(found.size(), 4u);
  for (const Contact& contact : found) {
    EXPECT_NEAR(contact.p_W.head<2>().norm(), 0.02, 1e-12);
    EXPECT_NEAR(contact.depth_m, 1e-6, 1e-12);
  }
}

scene::TrayType one_pocket(double radius_m, double depth_m) {
  scene::TrayType tray;
  tray.name = "one";
  tray.min_xy = {-0.1, -0.1};
  tray.max_xy = {0.1, 0.1};
  tray.thickness_m = 0.02;
  tray.mass_kg = 1;
  scene::Slot slot;
  slot.name = "s";
  slot.pocket = {radius_m, radius_m, depth_m};
  tray.slots.push_back(slot);
  return tray;
}

/// How deep a point of a piece lies in a tray with one pocket, at most.
double deepest_sample(const std::vector<Vector3d>& points, const Isometry3d& X,
                      const scene::TrayType& tray) {
  double deepest = 0;
  for (const Vector3d& p : points) deepest = std::max(deepest, -test::tray_distance(tray, X * p));
  return deepest;
}

// A cube in a round pocket: its corners meet wall and floor as an oracle by distances says, and it
// rests on a mouth that is smaller.
TEST(PieceContacts, RandomCubesInARoundPocket) {
  std::mt19937_64 random(6);
  const scene::TrayType tray = one_pocket(0.02, 0.012);
  const Vector3d size(0.02, 0.02, 0.03);
  const ConvexPiece cube({api::BoxPiece{size}, {}});
  const auto edges = test::box_edges(size, 200);
  int held = 0;
  for (int i = 0; i < 2000; ++i) {
    const double tilt = test::uniform(random, 0, 0.05);
    const Isometry3d X =
        test::tilted(test::uniform(random, -0.008, 0.008), test::uniform(random, -0.008, 0.008),
                     0.015 - 0.012 + test::uniform(random, -2e-4, 3e-4), tilt,
                     test::uniform(random, -3, 3)) *
        Eigen::AngleAxisd(test::uniform(random, -3, 3), Vector3d::UnitZ());
    const double sampled = deepest_sample(edges, X, tray);
    if (sampled > 5e-4) continue;
    std::vector<Contact> found;
    shape_on_tray(cube.shape(), X, tray, Isometry3d::Identity(), {1, 0, SurfacePair::kPart}, found);
    const double deepest = test::deepest(found);
    // Sampled edges miss the deepest point by little; tilted edges on the rim are the shallower way
    // out, by up to a quarter.
    EXPECT_NEAR(deepest, sampled, 2e-5 + 0.25 * sampled) << i << ' ' << tilt;
    held += sampled > 0;
  }
  EXPECT_GT(held, 200);
  // On the mouth: four corners of 50 mm over a pocket of 40 mm.
  const ConvexPiece plate({api::BoxPiece{{0.05, 0.05, 0.01}}, {}});
  Isometry3d lying = Isometry3d::Identity();
  lying.translation().z() = 0.005 - 1e-6;
  std::vector<Contact> found;
  shape_on_tray(plate.shape(), lying, tray, Isometry3d::Identity(), {1, 0, SurfacePair::kPart},
                found);
  ASSERT_GE(found.size(), 4u);
  for (const Contact& contact : found) {
    EXPECT_NEAR(contact.n_W.z(), 1, 1e-12);
    EXPECT_NEAR(contact.depth_m, 1e-6, 1e-12);
  }
}

/// Distance of a point outside the material from a tray with a pocket of vertical walls.
double distance_outside(const Vector3d& p, double radius_m, double depth_m) {
  const double r = p.head<2>().norm();
  if (r >= radius_m) return p.z();
  if (p.z() > 0) return std::min(std::hypot(radius_m - r, p.z()), p.z() + depth_m);
  return std::min(radius_m - r, p.z() + depth_m);
}

TEST(PieceContacts, RandomBallsInARoundPocket) {
  std::mt19937_64 random(8);
  const scene::TrayType tray = one_pocket(0.02, 0.012);
  for (int i = 0; i < 4000; ++i) {
    const double r = test::uniform(random, 0.003, 0.03);
    const ConvexPiece ball({api::CapsulePiece{r, 0}, {}});
    Isometry3d X = Isometry3d::Identity();
    X.translation() =
        Vector3d(test::uniform(random, -0.03, 0.03), test::uniform(random, -0.03, 0.03),
                 test::uniform(random, -0.008, 0.03));
    const double distance = distance_outside(X.translation(), 0.02, 0.012);
    if (distance < 1e-3) continue;  // its centre in the material, or near it
    std::vector<Contact> found;
    shape_on_tray(ball.shape(), X, tray, Isometry3d::Identity(), {1, 0, SurfacePair::kPart}, found);
    EXPECT_NEAR(test::deepest(found), std::max(0.0, r - distance), 1e-8)
        << i << ' ' << X.translation().transpose() << ' ' << r;
  }
}

// A ray meets the surface: at the point the distance is 0, and before it there is nothing.
TEST(PieceContacts, RandomRaysEndOnTheSurface) {
  std::mt19937_64 random(9);
  for (int i = 0; i < 3000; ++i) {
    const ConvexPiece piece(any_piece(random));
    const Isometry3d X_WP = random_pose(random, 0.01);
    const Vector3d from = random_pose(random, 0.1).translation();
    const Vector3d aim = random_pose(random, 0.025).translation();
    const Vector3d d = (X_WP * aim - from).normalized();
    const double t = distance_to_piece(piece, X_WP, {from, d});
    const auto distance = [&](double way) {
      return piece.nearness(X_WP.inverse() * (from + way * d)).distance;
    };
    if (distance(0) <= 0) {
      EXPECT_EQ(t, 0) << i;
    } else if (t == kNoHit) {
      for (double way = 0; way < 0.2; way += 1e-3) EXPECT_GT(distance(way), -1e-9) << i;
    } else {
      EXPECT_NEAR(distance(t), 0, 1e-9) << i;
      EXPECT_GT(distance(0.99 * t), 0) << i;
    }
  }
}

TEST(PieceContacts, PointsOfOnePlaneAreJoined) {
  std::vector<Contact> contacts;
  for (int i = 0; i < 20; ++i) {
    Contact contact;
    contact.p_W = {0.01 * (i % 5), 0.01 * (i / 5), 0};
    contact.depth_m = 1e-6;
    contact.pair = SurfacePair::kPart;
    contacts.push_back(contact);
  }
  reduce_planes(0, contacts);
  EXPECT_LE(contacts.size(), 8u);
  const auto has = [&](double x, double y) {
    return std::ranges::any_of(
        contacts, [&](const Contact& c) { return (c.p_W - Vector3d(x, y, 0)).norm() < 1e-12; });
  };
  EXPECT_TRUE(has(0, 0) && has(0.04, 0) && has(0, 0.03) && has(0.04, 0.03));
}

}  // namespace
}  // namespace aprsim::physics
