#include "world/physics/collision/speculative/hull_gap.hpp"

#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/world/physics/collision/solids.hpp"

namespace aprsim::physics {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

const detail::GearShape kGear(test::conical_gear()), kOther(test::cylindrical_gear());
const Vector3d kBox(0.12, 0.05, 0.02), kSlab(0.16, 0.16, 0.015);

enum class Hulls { kGears, kGearAndBox, kBoxes };

const char* name_of(Hulls hulls) {
  if (hulls == Hulls::kGears) return "Gears";
  return hulls == Hulls::kGearAndBox ? "GearAndBox" : "Boxes";
}
void PrintTo(Hulls hulls, std::ostream* out) { *out << name_of(hulls); }

HullGap gap(Hulls hulls, const Isometry3d& X_WA, const Isometry3d& X_WB) {
  if (hulls == Hulls::kGears) return gear_gear_gap(kGear, X_WA, kOther, X_WB);
  if (hulls == Hulls::kGearAndBox) return gear_box_gap(kGear, X_WA, kSlab, X_WB);
  return box_box_gap(kBox, X_WA, kSlab, X_WB);
}

bool touch(Hulls hulls, const Isometry3d& X_WA, const Isometry3d& X_WB) {
  std::vector<Contact> out;
  if (hulls == Hulls::kGears) {
    gear_gear(kGear, X_WA, kOther, X_WB, 1, 0, out);
  } else if (hulls == Hulls::kGearAndBox) {
    gear_box(kGear, X_WA, kSlab, X_WB, 1, 0, SurfacePair::kGearGround, out);
  } else {
    box_box(kBox, X_WA, kSlab, X_WB, 1, 0, SurfacePair::kTrayTray, out);
  }
  return !out.empty();
}

Isometry3d shifted(const Isometry3d& X, const Vector3d& by) { return Eigen::Translation3d(by) * X; }

class HullGapOf : public testing::TestWithParam<Hulls> {};

// Hulls reported apart do not touch in any attitude, nor when they have come nearer by
// almost as much; and along the axis of the gap bodies come apart at the full rate.
TEST_P(HullGapOf, IsNeverMoreThanTheDistance) {
  constexpr double kReach = 0.13, kAlmost = 0.999;
  std::mt19937_64 random(8);
  int apart = 0, touching = 0;
  for (int i = 0; i < 4000; ++i) {
    Isometry3d X_WA = test::random_rotation(random), X_WB = test::random_rotation(random);
    for (int k = 0; k < 3; ++k) X_WA.translation()(k) = test::uniform(random, -kReach, kReach);
    X_WB.translation() = Vector3d(0.3, -0.2, 0.1);
    X_WA.translation() += X_WB.translation();
    const HullGap found = gap(GetParam(), X_WA, X_WB);
    ASSERT_NEAR(found.n_W.norm(), 1, 1e-12);
    const double by = test::uniform(random, 0, 0.05);
    EXPECT_GE(gap(GetParam(), shifted(X_WA, by * found.n_W), X_WB).m, found.m + by - 1e-12);
    touching += touch(GetParam(), X_WA, X_WB);
    if (found.m <= 0) continue;
    ++apart;
    ASSERT_FALSE(touch(GetParam(), X_WA, X_WB)) << i;
    ASSERT_FALSE(touch(GetParam(), shifted(X_WA, -kAlmost * found.m * found.n_W), X_WB)) << i;
  }
  EXPECT_GT(apart, 400);
  EXPECT_GT(touching, 100);
}

INSTANTIATE_TEST_SUITE_P(All, HullGapOf,
                         testing::Values(Hulls::kGears, Hulls::kGearAndBox, Hulls::kBoxes),
                         [](const auto& test) { return name_of(test.param); });

TEST(HullGap, FaceToFaceIsTheDistance) {
  constexpr double kGapM = 0.013;
  const Isometry3d slab = test::pose(0, 0, 0);
  const HullGap over = gear_box_gap(
      kGear, test::pose(0.02, -0.01, 0.5 * kSlab.z() + kGapM - kGear.z_low), kSlab, slab);
  EXPECT_NEAR(over.m, kGapM, 1e-12);
  EXPECT_TRUE(over.n_W.isApprox(Vector3d::UnitZ(), 1e-12));
  const HullGap under =
      box_box_gap(kBox, test::pose(0, 0.02, -0.5 * (kBox.z() + kSlab.z()) - kGapM), kSlab, slab);
  EXPECT_NEAR(under.m, kGapM, 1e-12);
  EXPECT_TRUE(under.n_W.isApprox(-Vector3d::UnitZ(), 1e-12));
  const double level = kOther.middle().z() - kGear.middle().z();
  const HullGap beside = gear_gear_gap(
      kGear, test::pose(kGear.r_max + kOther.r_max + kGapM, 0, level), kOther, test::pose(0, 0, 0));
  EXPECT_NEAR(beside.m, kGapM, 1e-12);
  EXPECT_TRUE(beside.n_W.isApprox(Vector3d::UnitX(), 1e-12));
}

}  // namespace
}  // namespace aprsim::physics
