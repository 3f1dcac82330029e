// Polynomials between two points, against Hermite's basis and the conditions at their ends.

#include "world/robot/trajectory/stream/joint_curve.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace aprsim::robot {
namespace {

class RandomCurve : public testing::TestWithParam<int> {
 protected:
  JointVector random(double most) {
    JointVector v(6);
    for (int i = 0; i < 6; ++i) v(i) = std::uniform_real_distribution(-most, most)(engine);
    return v;
  }
  CurvePoint point(SimTime time, bool accelerations) {
    CurvePoint out{time, random(3), random(2), {}};
    if (accelerations) out.qdd = random(5);
    return out;
  }
  std::mt19937 engine{static_cast<unsigned>(GetParam())};
};

TEST_P(RandomCurve, ACubicOneIsHermites) {
  const CurvePoint a = point(std::chrono::milliseconds(40), false);
  const CurvePoint b = point(std::chrono::milliseconds(40 + 4 * (1 + GetParam())), false);
  const JointCurve curve(a, b);
  ASSERT_EQ(curve.degree(), 3);
  const double T = curve.duration();
  for (int k = 0; k <= 100; ++k) {
    const double s = k / 100.0;
    const double h00 = (1 + 2 * s) * (1 - s) * (1 - s), h10 = s * (1 - s) * (1 - s);
    const double h01 = s * s * (3 - 2 * s), h11 = s * s * (s - 1);
    const JointVector expected = h00 * a.q + h10 * T * a.qd + h01 * b.q + h11 * T * b.qd;
    EXPECT_LE((curve.at(s * T).q - expected).cwiseAbs().maxCoeff(), 1e-12) << s;
  }
}

TEST_P(RandomCurve, AQuinticOneMeetsBothStates) {
  const CurvePoint a = point(SimTime(0), true);
  const CurvePoint b = point(std::chrono::milliseconds(100 * (1 + GetParam())), true);
  const JointCurve curve(a, b);
  ASSERT_EQ(curve.degree(), 5);
  const JointState first = curve.at(0), last = curve.at(curve.duration());
  EXPECT_EQ(first.q, a.q);
  EXPECT_EQ(first.qd, a.qd);
  EXPECT_EQ(first.qdd, a.qdd);
  EXPECT_LE((last.q - b.q).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LE((last.qd - b.qd).cwiseAbs().maxCoeff(), 1e-10);
  EXPECT_LE((last.qdd - b.qdd).cwiseAbs().maxCoeff(), 1e-8);
}

TEST_P(RandomCurve, WithoutVelocitiesItIsALine) {
  CurvePoint a = point(SimTime(0), false), b = point(std::chrono::seconds(1), false);
  b.qd = {};
  const JointCurve curve(a, b);
  EXPECT_EQ(curve.degree(), 1);
  EXPECT_LE((curve.at(0.25).q - (0.75 * a.q + 0.25 * b.q)).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LE((curve.at(0.25).qd - (b.q - a.q)).cwiseAbs().maxCoeff(), 1e-12);
}

TEST_P(RandomCurve, ItsExtentHoldsAtEveryInstant) {
  for (const bool quintic : {false, true}) {
    const CurvePoint a = point(SimTime(0), quintic), b = point(std::chrono::seconds(2), quintic);
    const JointCurve curve(a, b);
    for (int joint = 0; joint < 6; ++joint) {
      const JointCurve::Extent extent = curve.extent(joint);
      double lowest = 1e9, highest = -1e9, speed = 0;
      for (int k = 0; k <= 4000; ++k) {
        const JointState state = curve.at(k * curve.duration() / 4000);
        lowest = std::min(lowest, state.q(joint));
        highest = std::max(highest, state.q(joint));
        speed = std::max(speed, std::abs(state.qd(joint)));
      }
      // A quintic one is sampled.
      const double tolerance = quintic ? 0.1 : 1e-5;
      EXPECT_NEAR(extent.lowest, lowest, tolerance);
      EXPECT_NEAR(extent.highest, highest, tolerance);
      EXPECT_NEAR(extent.speed, speed, tolerance);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Curves, RandomCurve, testing::Range(0, 20));

}  // namespace
}  // namespace aprsim::robot
