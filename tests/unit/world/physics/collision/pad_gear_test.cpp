#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/holding_gap.hpp"
#include "tests/support/parameter_names.hpp"
#include "tests/unit/world/physics/collision/solids.hpp"

namespace aprsim::physics {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kPegR = 0.00385;

Pad pad_of(scene::PadShape shape) {
  Pad pad;
  pad.shape = shape;
  pad.height_m = 0.018;
  pad.width_m = 0.022;
  pad.depth_m = 0.012;
  pad.v_half_angle_rad = std::numbers::pi / 4;
  return pad;
}

/// The finger stands in the world; the gear's peg is at (x, y) of the finger frame, the gear's
/// frame at height z, tilted about the finger's x axis.
Isometry3d gear_at(double x, double y, double z, double tilt = 0) {
  return test::tilted(x, y, z, tilt, 0);
}

const Isometry3d kFinger =
    test::pose(0.3, -0.2, 1.1) * Eigen::AngleAxisd(0.6, Vector3d(1, 2, -1).normalized());

std::vector<Contact> touch(const Pad& pad, const Isometry3d& X_DG) {
  std::vector<Contact> out;
  pad_gear(pad, kFinger, test::conical_gear(), kFinger * X_DG, 7, 2, out);
  for (Contact& c : out) {  // into the finger frame
    c.p_W = kFinger.inverse() * c.p_W;
    c.n_W = kFinger.linear().transpose() * c.n_W;
  }
  return out;
}

class PadGear : public testing::TestWithParam<scene::PadShape> {};
INSTANTIATE_TEST_SUITE_P(Shapes, PadGear,
                         testing::Values(scene::PadShape::kFlat, scene::PadShape::kV));

TEST(PadGearFlat, HoldsThePegAtBothEndsOfTheLine) {
  const Pad pad = pad_of(scene::PadShape::kFlat);
  // Disc top 2 mm below the tip, peg top at 18 mm: inside the pad.
  const auto found = touch(pad, gear_at(0.003, kPegR - 5e-5, -0.008 - 0.001));
  ASSERT_EQ(found.size(), 2U);
  std::array<double, 2> z{};
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(found[i].a, 7);
    EXPECT_EQ(found[i].b, 2);
    EXPECT_EQ(found[i].pair, SurfacePair::kPadGear);
    EXPECT_NEAR(found[i].depth_m, 5e-5, 1e-10);
    EXPECT_LT((found[i].n_W + Vector3d::UnitY()).norm(), 1e-9);  // pushes the pad back
    EXPECT_NEAR(found[i].p_W.x(), 0.003, 1e-9);
    z[i] = found[i].p_W.z();
  }
  EXPECT_NEAR(std::min(z[0], z[1]), 0, 1e-9);
  EXPECT_NEAR(std::max(z[0], z[1]), -0.009 + 0.026, 1e-9);
}

TEST(PadGearV, HoldsThePegOnBothFacesAtBothEnds) {
  const Pad pad = pad_of(scene::PadShape::kV);
  const double half_gap = 0.5 * holding_gap(pad, kPegR);
  EXPECT_GT(half_gap, 0);
  const auto found = touch(pad, gear_at(0, half_gap - 5e-5, -0.009));
  ASSERT_EQ(found.size(), 4U);
  Vector3d push = Vector3d::Zero();
  for (const Contact& c : found) {
    EXPECT_NEAR(c.depth_m, 5e-5 * std::sin(pad.v_half_angle_rad), 1e-9);
    EXPECT_NEAR(std::abs(c.n_W.x()), std::cos(pad.v_half_angle_rad), 1e-9);
    EXPECT_NEAR(c.n_W.y(), -std::sin(pad.v_half_angle_rad), 1e-9);
    EXPECT_LT(c.p_W.y(), 0);  // in the groove
    push += c.n_W;
  }
  EXPECT_NEAR(push.x(), 0, 1e-9);
  EXPECT_TRUE(touch(pad, gear_at(0, half_gap + 1e-9, -0.009)).empty());
}

TEST(PadGearV, OffCentreOnlyOneFaceTouchesAndPushesToTheMiddle) {
  Pad pad = pad_of(scene::PadShape::kV);
  pad.v_depth_m = 0.005;
  const double half_gap = 0.5 * holding_gap(pad, kPegR);
  EXPECT_NEAR(half_gap, kPegR * std::numbers::sqrt2 - 0.005, 1e-12);
  const double x = 0.001;
  const auto found = touch(pad, gear_at(x, half_gap + x - 4e-5, -0.009));
  ASSERT_EQ(found.size(), 2U);
  for (const Contact& c : found) {
    EXPECT_NEAR(c.depth_m, 4e-5 * std::numbers::sqrt2 / 2, 1e-9);
    EXPECT_GT(c.n_W.x(), 0.7);  // the pad goes to +x, the gear to the middle
  }
}

TEST(PadGearV, BesideTheGrooveThePegMeetsTheRim) {
  const Pad pad = pad_of(scene::PadShape::kV);
  const double mouth = v_groove_depth(pad, kPegR);  // 45 degrees: as wide as deep
  const auto flat = touch(pad, gear_at(mouth + 0.004, kPegR - 3e-5, -0.009));
  ASSERT_EQ(flat.size(), 2U);
  for (const Contact& c : flat) EXPECT_LT((c.n_W + Vector3d::UnitY()).norm(), 1e-9);
  // Onto the edge between groove and rim: the normal leads through the peg's axis.
  const double x = mouth - 0.0015, r = kPegR - 2e-5;
  const auto edge = touch(pad, gear_at(x, std::sqrt(r * r - 0.0015 * 0.0015), -0.009));
  ASSERT_GE(edge.size(), 2U);
  EXPECT_NEAR(test::deepest(edge), 2e-5, 1e-9);
  for (const Contact& c : edge) EXPECT_NEAR(c.n_W.x(), 0.0015 / r, 1e-6);
}

TEST(PadGear2, AGearThatIsPinchedCentresInTwoVPads) {
  const Pad pad = pad_of(scene::PadShape::kV);
  EXPECT_NEAR(holding_gap(pad_of(scene::PadShape::kFlat), kPegR), 2 * kPegR, 1e-12);
  EXPECT_LT(holding_gap(pad, kPegR), 2 * kPegR);
  EXPECT_LE(v_groove_depth(pad, 0.05), 0.8 * pad.depth_m);
}

TEST_P(PadGear, ATiltedPegTouchesWithOneEndDeeper) {
  const Pad pad = pad_of(GetParam());
  const double y = 0.5 * holding_gap(pad, kPegR);
  // About the finger's x axis: the peg's top leans into the pad.
  const auto found = touch(pad, gear_at(0, y - 5e-5, 0, 0.01) * test::pose(0, 0, -0.009));
  ASSERT_FALSE(found.empty());
  for (const Contact& c : found) EXPECT_GT(c.depth_m, 0);
  const Contact& deep =
      *std::max_element(found.begin(), found.end(),
                        [](const Contact& a, const Contact& b) { return a.depth_m < b.depth_m; });
  EXPECT_GT(deep.p_W.z(), 0.015);
  EXPECT_NEAR(deep.depth_m,
              (5e-5 + 0.017 * 0.01) * (GetParam() == scene::PadShape::kV ? std::sqrt(0.5) : 1.0),
              5e-6);
}

TEST_P(PadGear, TheUndersideStopsAFingerOnThePeg) {
  const Pad pad = pad_of(GetParam());
  // Peg wholly or partly below the finger's body, its top slightly above the underside.
  for (const double y : {-0.007, -0.005, -0.002, 0.001, 0.002}) {
    for (const double depth : {1e-5, 2e-4, 8e-4}) {
      for (const double x : {0.0, 0.004, -0.0065}) {
        const Isometry3d X = gear_at(x, y, depth - 0.026);
        const auto found = touch(pad, X);
        if (found.empty()) {  // a peg in the open groove
          EXPECT_EQ(GetParam(), scene::PadShape::kV);
          EXPECT_GT(y, -0.001);
          continue;
        }
        const Contact& deep = *std::max_element(
            found.begin(), found.end(),
            [](const Contact& a, const Contact& b) { return a.depth_m < b.depth_m; });
        if (depth > 1e-4 && y > 0) continue;  // a corner: sideways may be shorter
        EXPECT_NEAR(deep.depth_m, depth, 1e-9) << x << " " << y;
        EXPECT_GT(deep.n_W.z(), 0.999) << x << " " << y << " " << depth;
      }
    }
  }
}

TEST_P(PadGear, TheTipStandsOnTheDisc) {
  const Pad pad = pad_of(GetParam());
  // Too low: the tip is 20 um in the disc's top, the peg clear of the pad.
  const auto found = touch(pad, gear_at(0, 0.012, -0.006 + 2e-5));
  ASSERT_GE(found.size(), 3U);
  for (const Contact& c : found) {
    EXPECT_NEAR(c.depth_m, 2e-5, 1e-9);
    EXPECT_TRUE(c.n_W.isApprox(Vector3d::UnitZ(), 1e-9));
  }
}

TEST_P(PadGear, TheDiscsRimMeetsTheFingersBody) {
  const Pad pad = pad_of(GetParam());
  // The finger's back is towards the gear; the disc lies half way up the finger.
  const auto found = touch(pad, gear_at(0, -0.012 - 0.032 + 3e-5, 0.005));
  ASSERT_GE(found.size(), 2U);
  for (const Contact& c : found) {
    EXPECT_NEAR(c.depth_m, 3e-5, 1e-9);
    EXPECT_LT((c.n_W - Vector3d::UnitY()).norm(), 1e-6);
  }
}

TEST_P(PadGear, ContactsAreContinuousWhileThePadCloses) {
  const Pad pad = pad_of(GetParam());
  double before = -1;
  const double y0 = 0.5 * holding_gap(pad, kPegR) + 1e-4;
  for (int i = 0; i <= 2000; ++i) {
    const double depth = test::deepest(touch(pad, gear_at(4e-4, y0 - 5e-7 * i, -0.009, 0.003)));
    if (before >= 0) {
      EXPECT_LE(std::abs(depth - before), 6e-7) << i;
    }
    before = depth;
  }
  EXPECT_GT(before, 3e-4);
}

// A disc that cuts a corner of the pad overlaps far with every face, and little of it is inside.
TEST(PadGearV, ADiscPastACornerIsNoDeeperThanWhatIsInside) {
  Pad pad = pad_of(scene::PadShape::kV);
  pad.height_m = 0.03;
  pad.width_m = 0.014;
  pad.depth_m = 0.01;
  const Vector3d past(-6.7e-3, -34.0e-3, -0.3e-3);
  const Eigen::Quaterniond leaning(-0.0729, 0.929, 0.2993, -0.2052);
  std::mt19937_64 random(68);
  int touching = 0;
  for (int i = 0; i < 300; ++i) {
    Isometry3d X = Isometry3d::Identity();
    X.translation() = past;
    for (int k = 0; k < 3; ++k) X.translation()(k) += test::uniform(random, -2e-4, 2e-4);
    const Vector3d axis = test::random_rotation(random).linear().col(0);
    X.linear() = (leaning.normalized() *
                  Eigen::Quaterniond(Eigen::AngleAxisd(test::uniform(random, 0, 0.02), axis)))
                     .toRotationMatrix();
    const auto found = touch(pad, X);
    touching += !found.empty();
    EXPECT_LE(test::deepest(found), 2e-3) << i;
  }
  EXPECT_GT(touching, 100);
}

}  // namespace
}  // namespace aprsim::physics
