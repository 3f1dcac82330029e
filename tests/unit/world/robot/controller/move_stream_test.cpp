// Moves streamed to a controller: one moves, one waits; corners are rounded within the limits.

#include <random>
#include <string>

#include <gtest/gtest.h>

#include "tests/unit/world/robot/controller/stream_rig.hpp"

namespace aprsim::robot {
namespace {

using Phase = api::StreamPhase;

class MoveStream : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    rig.ready();
    ASSERT_EQ(rig.claim(api::StreamMode::kMoves), "");
    rig.forget();
  }
  std::string append(const JointVector& q, double speed = 0.2, double rounding = 0.5) {
    return rig.send(api::AppendMove{rig.stream, values_of(q), speed, rounding, 1});
  }
  StreamRig rig{GetParam()};
};

TEST_P(MoveStream, OneMovesOneWaitsAThirdIsRefused) {
  JointVector q = rig.controller().reference();
  q(0) += 0.5;
  ASSERT_EQ(append(q), "");
  rig.steps(1);
  q(0) -= 0.3;
  ASSERT_EQ(append(q), "");
  EXPECT_EQ(rig.motion().points_left, 2u);
  EXPECT_NE(append(q).find("1 moves wait, the limit is 1"), std::string::npos);
  rig.finish();
  EXPECT_EQ(rig.controller().reference(), q);
  EXPECT_EQ(rig.motion().points_done, 2u);
  EXPECT_EQ(rig.motion().phase, Phase::kReady);
}

TEST_P(MoveStream, AMoveTakesItsShareOfTheSpeedOnAStraightLine) {
  JointVector q = rig.controller().reference();
  const JointVector start = q;
  q(0) += 1.0;
  q(1) += 0.2;
  ASSERT_EQ(append(q, 0.2), "");
  rig.finish();
  double fastest = 0;
  for (std::size_t k = 1; k < rig.path().size(); ++k) {
    const JointVector d = rig.path()[k] - start;
    EXPECT_NEAR(d(1), 0.2 * d(0), 1e-12);
    fastest = std::max(fastest, (rig.path()[k] - rig.path()[k - 1])(0) / 1e-3);
  }
  EXPECT_NEAR(fastest, 0.2 * rig.limits().speed(0), 1e-6);
}

TEST_P(MoveStream, RoundingSavesTimeAndCutsTheCorner) {
  const JointVector start = rig.controller().reference();
  JointVector corner = start, end = start;
  corner(0) += 0.5;
  end(0) += 0.5;
  end(1) += 0.3;
  std::vector<std::size_t> steps;
  std::vector<double> distance;
  for (const double rounding : {0.0, 0.5, 1.0}) {
    StreamRig each(GetParam());
    each.ready();
    ASSERT_EQ(each.claim(api::StreamMode::kMoves), "");
    each.forget();
    ASSERT_EQ(each.send(api::AppendMove{each.stream, values_of(corner), 0.2, rounding, 2}), "");
    ASSERT_EQ(each.send(api::AppendMove{each.stream, values_of(end), 0.2, 0, 2}), "");
    each.finish();
    EXPECT_EQ(each.controller().reference(), end);
    EXPECT_LE(each.effort().accel, 1 + 1e-3);
    steps.push_back(each.path().size());
    double nearest = 1;
    for (const JointVector& q : each.path()) nearest = std::min(nearest, (q - corner).norm());
    distance.push_back(nearest);
  }
  EXPECT_EQ(distance[0], 0) << "without rounding it stops in the corner";
  EXPECT_GT(distance[1], 1e-5);
  EXPECT_GT(distance[2], distance[1]);
  EXPECT_LT(steps[1], steps[0]);
  EXPECT_LT(steps[2], steps[1]);
}

TEST_P(MoveStream, RandomMovesStayWithinTheLimitsAndEndExactly) {
  std::mt19937 engine(21);
  for (int i = 0; i < 40; ++i) {
    const JointVector q = rig.random_posture(engine, 0.1);
    const double speed = std::uniform_real_distribution(0.05, 1.0)(engine);
    const double rounding = std::uniform_real_distribution(0.0, 1.0)(engine);
    for (int wait = 0; wait < 60000 && rig.motion().points_left > 1; ++wait) rig.step();
    ASSERT_EQ(append(q, speed, rounding), "") << i;
    rig.step();
    if (i % 7 != 6) continue;
    rig.finish();
    EXPECT_EQ(rig.controller().reference(), q) << i;
  }
  EXPECT_LE(rig.effort().speed, 1 + 1e-3);
  EXPECT_LE(rig.effort().accel, 1 + 1e-3);
}

TEST_P(MoveStream, APostureBeyondTheRangeIsAnAlarm) {
  JointVector q = rig.controller().reference();
  q(0) += 0.3;
  ASSERT_EQ(append(q), "");
  rig.steps(300);
  q(2) = rig.limits().upper(2) + 0.02;
  const std::string error = append(q);
  EXPECT_NE(error.find(rig.model().joints[2].name + ": position"), std::string::npos) << error;
  EXPECT_EQ(rig.last_end().result, api::StreamResult::kAlarm);
  rig.rest();
  ASSERT_EQ(rig.claim(api::StreamMode::kMoves, true), "");
  EXPECT_EQ(rig.motion().alarm, "");
}

TEST_P(MoveStream, StopsAndPauses) {
  JointVector q = rig.controller().reference();
  q(0) += 1;
  ASSERT_EQ(append(q, 0.1), "");
  rig.steps(600);
  ASSERT_EQ(rig.send(api::PauseStream{rig.stream, true}), "");
  rig.steps(1500);
  EXPECT_FALSE(rig.controller().moving());
  EXPECT_EQ(rig.motion().phase, Phase::kPaused);
  EXPECT_EQ(rig.motion().points_left, 1u);
  ASSERT_EQ(rig.send(api::PauseStream{rig.stream, false}), "");
  rig.steps(100);
  ASSERT_EQ(rig.send(api::StopStream{rig.stream}), "");
  rig.finish();
  EXPECT_LT(rig.controller().reference()(0), q(0));
  EXPECT_EQ(rig.motion().phase, Phase::kReady);
  ASSERT_EQ(append(q), "");
  rig.finish();
  EXPECT_EQ(rig.controller().reference(), q);
}

INSTANTIATE_TEST_SUITE_P(Arms, MoveStream, testing::Values("fanuc", "motoman"));

}  // namespace
}  // namespace aprsim::robot
