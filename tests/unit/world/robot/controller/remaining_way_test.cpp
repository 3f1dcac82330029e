// The way that is left of a robot's motions, which other robots avoid: the references of all later
// steps lie on it.

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/world/robot/controller/controller_rig.hpp"

namespace aprsim::robot {
namespace {

/// Distance of a posture from the lines between others [rad].
double distance_from(const JointVector& q, const std::vector<JointVector>& way) {
  double least = (q - way.front()).norm();
  for (std::size_t i = 1; i < way.size(); ++i) {
    const JointVector along = way[i] - way[i - 1];
    const double square = along.squaredNorm();
    const double share =
        square > 0 ? std::clamp((q - way[i - 1]).dot(along) / square, 0.0, 1.0) : 0.0;
    least = std::min(least, (q - way[i - 1] - share * along).norm());
  }
  return least;
}

class RemainingWay : public testing::TestWithParam<const char*> {
 protected:
  RemainingWay() : rig(GetParam()) { rig.ready(); }
  api::MoveTo shifted(double z, bool straight) const {
    Pose X = rig.tool();
    X.p.z() += z;
    return {X, straight};
  }
  std::vector<JointVector> remaining() {
    std::vector<JointVector> way;
    rig.controller().remaining(64, way);
    return way;
  }
  void expect_on_way() {
    const std::vector<JointVector> way = remaining();
    ASSERT_GT(way.size(), 2U);
    rig.forget();
    rig.rest();
    for (const JointVector& q : rig.path()) EXPECT_LT(distance_from(q, way), 2e-3);
    EXPECT_LT((way.back() - rig.controller().reference()).norm(), 2e-3);
  }

  ControllerRig rig;
};
INSTANTIATE_TEST_SUITE_P(Arms, RemainingWay, testing::Values("fanuc", "motoman"),
                         [](const auto& arm) { return std::string(arm.param); });

TEST_P(RemainingWay, AtRestItIsTheReference) {
  const auto way = remaining();
  ASSERT_EQ(way.size(), 1U);
  EXPECT_EQ(way.front(), rig.controller().reference());
}

TEST_P(RemainingWay, HoldsAllReferencesOfFreeAndStraightMoves) {
  for (const bool straight : {false, true}) {
    for (const int steps : {20, 400}) {
      rig.apply(shifted(straight ? -0.1 : 0.1, straight));
      rig.steps(steps);
      expect_on_way();
    }
  }
}

TEST_P(RemainingWay, EndsWhereABrakedMotionStops) {
  rig.apply(shifted(-0.1, true));
  rig.steps(300);
  rig.apply(api::StopMotion{api::StopKind::kNormal});
  expect_on_way();
}

TEST_P(RemainingWay, GoesOnWhereTheOverrideHoldsTheMotion) {
  for (const bool straight : {false, true}) {
    rig.apply(shifted(straight ? -0.1 : 0.1, straight));
    rig.steps(300);
    rig.apply(api::SetOverride{0});
    rig.steps(500);
    const auto way = remaining();
    rig.apply(api::SetOverride{1});
    rig.rest();
    EXPECT_LT((way.back() - rig.controller().reference()).norm(), 2e-3);
  }
}

}  // namespace
}  // namespace aprsim::robot
