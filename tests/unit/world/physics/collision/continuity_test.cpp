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

struct Change {
  double depth = 0;  ///< of the deepest contact, per unit of motion
  int count = 0;     ///< steps in which the number of contacts changed
};

/// Follows a motion and finds the largest change of the deepest depth over one small step.
template <class Pose>
Change largest_change(const scene::GearType& g, const scene::TrayType& t, int steps, double motion,
                      const Pose& pose) {
  Change change;
  double before = -1;
  std::size_t count = 0;
  for (int i = 0; i <= steps; ++i) {
    std::vector<Contact> found;
    gear_tray(g, pose(static_cast<double>(i) / steps), t, Isometry3d::Identity(), 1, 0, found);
    const double depth = test::deepest(found);
    if (before >= 0) {
      change.depth = std::max(change.depth, std::abs(depth - before) / (motion / steps));
      change.count += found.size() != count;
    }
    before = depth;
    count = found.size();
  }
  return change;
}

class Continuity : public testing::TestWithParam<bool> {
 protected:
  scene::GearType gear() const {
    return GetParam() ? test::conical_gear() : test::cylindrical_gear();
  }
  scene::TrayType tray() const {
    return GetParam() ? test::conical_tray() : test::cylindrical_tray();
  }
};
INSTANTIATE_TEST_SUITE_P(Kinds, Continuity, testing::Values(true, false));

TEST_P(Continuity, SlidingIntoTheWall) {
  const Change change = largest_change(gear(), tray(), 4000, 0.6e-3, [](double s) {
    return test::pose(0.045 + 0.6e-3 * s, 0.045, 0.2e-3);
  });
  EXPECT_LE(change.depth, 1.01);  // depth grows no faster than the gear moves
  EXPECT_LE(change.count, 4);
}

TEST_P(Continuity, CirclingTheWall) {
  const double off = 0.45e-3;
  const Change change =
      largest_change(gear(), tray(), 4000, 2 * std::numbers::pi * off, [&](double s) {
        return test::pose(0.045 + off * std::cos(2 * std::numbers::pi * s),
                          0.045 + off * std::sin(2 * std::numbers::pi * s), 0.2e-3);
      });
  EXPECT_LE(change.depth, 1e-3);
  EXPECT_EQ(change.count, 0);
}

TEST_P(Continuity, TiltingFromLevelOnTheShoulder) {
  const double reach = gear().disc_radius_m;
  for (const double heading : {0.0, 0.3, 0.785, 1.5, 3.0}) {
    const double end = 2e-3;
    const Change change = largest_change(gear(), tray(), 4000, end * reach, [&](double s) {
      return test::tilted(0.045, 0.045, -2e-6, end * s, heading);
    });
    EXPECT_LE(change.depth, 1.5) << heading;  // the blend turns the points a little faster
  }
}

TEST_P(Continuity, LoweringTheHubOverTheMouthsRim) {
  const Change change = largest_change(gear(), tray(), 4000, 4e-3, [](double s) {
    return test::tilted(0.045 + 0.9e-3, 0.045, 3e-3 - 4e-3 * s, 0.02, 0.5);
  });
  EXPECT_LE(change.depth, 1.1);
}

TEST_P(Continuity, SlidingOverTheSlabsEdge) {
  scene::GearType g = gear();
  g.hub_height_m = 0;
  scene::TrayType t = tray();
  t.slots.clear();
  const int steps = 3000;
  for (int i = 0; i <= steps; ++i) {
    const double x = 0.03 + 0.07 * i / steps;
    const Isometry3d X = test::pose(x, 0, -1e-5);
    std::vector<Contact> found;
    gear_tray(g, X, t, Isometry3d::Identity(), 1, 0, found);
    ASSERT_GE(found.size(), 3U) << x;
    double most = -1;
    for (const Contact& c : found) {
      EXPECT_NEAR(c.depth_m, 1e-5, 1e-9) << x;
      EXPECT_LE(c.p_W.x(), 0.08 + 1e-9);
      most = std::max(most, c.p_W.x());
    }
    // The support reaches to the rim, or to the slab's edge.
    EXPECT_NEAR(most, std::min(0.08, x + g.disc_radius_m), 2e-3) << x;
  }
}

}  // namespace
}  // namespace aprsim::physics
