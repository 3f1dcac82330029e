#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <ostream>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/world/physics/collision/solids.hpp"

namespace aprsim::physics {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// One of the solids a gear meets, for the oracle.
struct Other {
  std::function<double(const Vector3d&)> distance;
  std::vector<Vector3d> edges;
  double top;
};

class Oracle {
 public:
  Oracle(const scene::GearType& gear, Other other)
      : gear_(gear), other_(std::move(other)), surface_(test::gear_surface(gear, 60)) {
    for (const Vector3d& p : test::gear_rims(gear, 1200)) surface_.push_back(p);
  }

  /// Deepest of the gear's surface in the other solid, and of the other's edges in the gear.
  [[nodiscard]] double overlap(const Isometry3d& X) const {
    double depth = 0;
    for (const Vector3d& p : surface_) {
      const Vector3d q = X * p;
      if (q.z() < other_.top - depth) depth = std::max(depth, -other_.distance(q));
    }
    const Isometry3d inverse = X.inverse();
    for (const Vector3d& p : other_.edges) {
      const Vector3d q = inverse * p;
      if (q.head<2>().squaredNorm() < 0.033 * 0.033)
        depth = std::max(depth, -test::gear_distance(gear_, q));
    }
    return depth;
  }

  /// Moves X along `way` from `out` to `in` times it, so far that it overlaps by about `depth`.
  [[nodiscard]] Isometry3d moved(Isometry3d X, const Vector3d& way, double out, double in,
                                 double depth) const {
    const Vector3d from = X.translation();
    for (int k = 0; k < 17; ++k) {
      const double middle = 0.5 * (in + out);
      X.translation() = from + middle * way;
      (overlap(X) < depth ? out : in) = middle;
    }
    X.translation() = from + in * way;
    return X;
  }
  /// Lowers X along z from clear above until it overlaps by about `depth`.
  [[nodiscard]] Isometry3d lowered(const Isometry3d& X, double depth) const {
    return moved(X, Vector3d::UnitZ(), 0.08, -0.03, depth);
  }

  void check(const Isometry3d& X, const std::vector<Contact>& found, const std::string& what) {
    const double depth = overlap(X);
    ++poses_;
    EXPECT_LE(found.size(), 8U) << what;
    if (depth > 2e-6) {
      ++touching_;
      ASSERT_FALSE(found.empty()) << what << " overlap " << depth;
    }
    const double seen = test::deepest(found);
    if (depth > 0 && depth < 1e-3) {
      EXPECT_GE(seen, 0.9 * depth - 2e-6) << what << " overlap " << depth;
      EXPECT_LE(seen, 3 * depth + 1.5e-4) << what << " overlap " << depth;
      worst_ = std::min(worst_, (seen + 1e-6) / (depth + 1e-6));
      most_ = std::max(most_, (seen + 1e-6) / (depth + 1e-6));
    }
    const Isometry3d inverse = X.inverse();
    for (const Contact& c : found) {
      EXPECT_GT(c.depth_m, 0) << what;
      EXPECT_NEAR(c.n_W.norm(), 1, 1e-9) << what;
      EXPECT_LE(test::gear_distance(gear_, inverse * c.p_W), 1e-9) << what;
      EXPECT_LE(other_.distance(c.p_W), 1e-9) << what;
      // Moved by its depth along the normal the point is free of one of the solids.
      const double after =
          std::max(other_.distance(c.p_W + c.depth_m * c.n_W),
                   test::gear_distance(gear_, inverse * (c.p_W - c.depth_m * c.n_W)));
      EXPECT_GE(after, -0.05 * c.depth_m - 1e-8) << what << " depth " << c.depth_m;
    }
  }

  void report(const char* name) const {
    EXPECT_GT(touching_, poses_ / 5);
    std::printf("%s: %d poses, %d touching, seen / oracle depth %.3f .. %.3f\n", name, poses_,
                touching_, worst_, most_);
  }

 private:
  scene::GearType gear_;
  Other other_;
  std::vector<Vector3d> surface_;
  int poses_ = 0, touching_ = 0;
  double worst_ = 1e9, most_ = 0;
};

Other tray_solid(const scene::TrayType& tray) {
  return {[tray](const Vector3d& p) { return test::tray_distance(tray, p); },
          test::tray_edges(tray, 1200), 0};
}

Other box_solid(const Vector3d& size) {
  return {[size](const Vector3d& p) { return test::box_distance(0.5 * size, p); },
          test::box_edges(size, 1200), 0.5 * size.z()};
}

std::string text(const Isometry3d& X) {
  std::ostringstream out;
  out.precision(17);
  out << "p " << X.translation().transpose() << " q "
      << Eigen::Quaterniond(X.linear()).coeffs().transpose();
  return out.str();
}

std::vector<Contact> on_tray(const scene::GearType& g, const scene::TrayType& t,
                             const Isometry3d& X) {
  std::vector<Contact> out;
  gear_tray(g, X, t, Isometry3d::Identity(), 1, 0, out);
  return out;
}

enum class GearAndTray { kConical, kCylindrical, kWedge };
void PrintTo(GearAndTray kind, std::ostream* out) {
  *out << std::array{"Conical", "Cylindrical", "Wedge"}.at(static_cast<std::size_t>(kind));
}

class RandomPose : public testing::TestWithParam<GearAndTray> {
 protected:
  /// Fewer poses for the tray with an outline, which differs at its sides only.
  static int poses(int all) { return GetParam() == GearAndTray::kWedge ? all / 3 : all; }
  scene::GearType gear() const {
    return GetParam() == GearAndTray::kCylindrical ? test::cylindrical_gear()
                                                   : test::conical_gear();
  }
  scene::TrayType tray() const {
    if (GetParam() == GearAndTray::kWedge) return test::wedge_tray();
    return GetParam() == GearAndTray::kConical ? test::conical_tray() : test::cylindrical_tray();
  }
};
INSTANTIATE_TEST_SUITE_P(Kinds, RandomPose,
                         testing::Values(GearAndTray::kConical, GearAndTray::kCylindrical,
                                         GearAndTray::kWedge),
                         testing::PrintToStringParamName());

TEST_P(RandomPose, NearTheSeat) {
  const scene::GearType g = gear();
  const scene::TrayType t = tray();
  Oracle oracle(g, tray_solid(t));
  std::mt19937_64 random(11);
  for (int i = 0; i < poses(700); ++i) {
    const double off = 1.2e-3;
    const Isometry3d X = test::tilted(0.045 + test::uniform(random, -off, off),
                                      -0.045 + test::uniform(random, -off, off),
                                      test::uniform(random, -0.3e-3, 3e-3),
                                      test::uniform(random, 0, 0.08), test::uniform(random, 0, 7));
    oracle.check(X, on_tray(g, t, X), text(X));
  }
  oracle.report("near the seat");
}

TEST_P(RandomPose, DroppedOnTheMouth) {
  const scene::GearType g = gear();
  const scene::TrayType t = tray();
  Oracle oracle(g, tray_solid(t));
  std::mt19937_64 random(13);
  for (int i = 0; i < poses(120); ++i) {
    const double off = 0.02;
    Isometry3d X = test::tilted(0.045 + test::uniform(random, -off, off),
                                0.045 + test::uniform(random, -off, off), 0,
                                test::uniform(random, 0, 0.4), test::uniform(random, 0, 7));
    X = oracle.lowered(X, test::uniform(random, 1e-5, 3e-4));
    oracle.check(X, on_tray(g, t, X), text(X));
  }
  oracle.report("dropped on the mouth");
}

TEST_P(RandomPose, TumblingOverTheWholeTray) {
  const scene::GearType g = gear();
  const scene::TrayType t = tray();
  Oracle oracle(g, tray_solid(t));
  std::mt19937_64 random(17);
  for (int i = 0; i < poses(150); ++i) {
    Isometry3d X = test::random_rotation(random);
    X.translation() << test::uniform(random, -0.1, 0.1), test::uniform(random, -0.1, 0.1), 0;
    if (i % 4 == 0) {
      X.linear() = test::tilted(0, 0, 0, test::uniform(random, 0, 0.3), 7.0 * i).linear();
    }
    X = oracle.lowered(X, test::uniform(random, 1e-5, 3e-4));
    if (oracle.overlap(X) > 5e-4) continue;  // never touched on its way down
    oracle.check(X, on_tray(g, t, X), text(X));
  }
  oracle.report("tumbling");
}

// From below and beside as well, over edges and corners.
TEST_P(RandomPose, FromAnySideOfTheTray) {
  const scene::GearType g = gear();
  const scene::TrayType t = tray();
  Oracle oracle(g, tray_solid(t));
  std::mt19937_64 random(29);
  for (int i = 0; i < poses(150); ++i) {
    Isometry3d X = test::random_rotation(random);
    const Vector3d way = test::random_rotation(random).linear().col(2);
    const Vector3d to(test::uniform(random, -0.09, 0.09), test::uniform(random, -0.09, 0.09),
                      test::uniform(random, -0.015, 0));
    X.translation() = to;
    X = oracle.moved(X, way, 0.3, 0, test::uniform(random, 1e-5, 3e-4));
    if (oracle.overlap(X) > 5e-4) continue;
    oracle.check(X, on_tray(g, t, X), text(X));
  }
  oracle.report("from any side");
}

// Face on face, either way up, on the top or on a pocket's floor: as it lies after a fall. The
// deepest point may be the only one inside.
TEST_P(RandomPose, HardlyTiltedAndHardlyTouching) {
  const scene::GearType g = gear();
  const scene::TrayType t = tray();
  Oracle oracle(g, tray_solid(t));
  std::mt19937_64 random(31);
  for (int i = 0; i < poses(150); ++i) {
    const double off = 0.012, tilt = std::pow(10, test::uniform(random, -5, -3));
    Isometry3d X = test::tilted(0.045 + test::uniform(random, -off, off),
                                0.045 + test::uniform(random, -off, off), 0, tilt,
                                test::uniform(random, 0, 7));
    if (i % 3 > 0) X.linear() = X.linear() * Vector3d(1, -1, -1).asDiagonal();
    X = oracle.lowered(X, 1e-6);
    X = oracle.moved(X, Vector3d::UnitZ(), 4e-6, -4e-6, tilt * test::uniform(random, 0, 4e-3));
    oracle.check(X, on_tray(g, t, X), text(X));
  }
}

TEST_P(RandomPose, NeverNothingHoweverDeep) {
  const scene::GearType g = gear();
  const scene::TrayType t = tray();
  Oracle oracle(g, tray_solid(t));
  std::mt19937_64 random(19);
  int touching = 0;
  for (int i = 0; i < poses(5000); ++i) {
    Isometry3d X = test::random_rotation(random);
    for (int k = 0; k < 2; ++k) X.translation()[k] = test::uniform(random, -0.11, 0.11);
    X.translation().z() = test::uniform(random, -0.05, 0.05);
    if (on_tray(g, t, X).empty()) {
      EXPECT_LT(oracle.overlap(X), 5e-6) << text(X);
    } else {
      ++touching;
    }
  }
  EXPECT_GT(touching, poses(2000));
}

TEST_P(RandomPose, OnABoxInAnyAttitude) {
  const scene::GearType g = gear();
  const Vector3d size(0.15, 0.12, 0.05);
  Oracle oracle(g, box_solid(size));
  std::mt19937_64 random(23);
  for (int i = 0; i < poses(200); ++i) {
    Isometry3d X = test::random_rotation(random);
    X.translation() << test::uniform(random, -0.1, 0.1), test::uniform(random, -0.09, 0.09), 0;
    X = oracle.lowered(X, test::uniform(random, 1e-5, 3e-4));
    if (oracle.overlap(X) > 5e-4) continue;
    std::vector<Contact> found;
    gear_box(g, X, size, Isometry3d::Identity(), 1, 0, SurfacePair::kGearGround, found);
    oracle.check(X, found, text(X));
  }
  oracle.report("on a box");
}

}  // namespace
}  // namespace aprsim::physics
