// Timed points streamed to a controller: interpolation, limits, stops, pauses, the end of points.

#include <chrono>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "tests/unit/world/robot/controller/stream_rig.hpp"

namespace aprsim::robot {
namespace {

using std::chrono::milliseconds;
using Phase = api::StreamPhase;

JointVector vector_of(const std::vector<double>& values) {
  return Eigen::Map<const JointVector>(values.data(), static_cast<Eigen::Index>(values.size()));
}

/// Hermite's cubic or the quintic through two points, by solving for its coefficients.
JointVector closed_form(const api::TrajectoryPoint& a, const api::TrajectoryPoint& b, double t) {
  const double T = seconds(b.time - a.time);
  const bool quintic = !a.acceleration_rad_s2.empty() && !b.acceleration_rad_s2.empty();
  const int n = quintic ? 6 : 4;
  JointVector out(static_cast<Eigen::Index>(a.position_rad.size()));
  // Conditions on the polynomial of s = t / T: value and derivatives at 0 and 1.
  Eigen::MatrixXd conditions = Eigen::MatrixXd::Zero(n, n);
  for (int k = 0; k < n; ++k) {
    conditions(1, k) = 1;
    conditions(3, k) = k;
    if (quintic) conditions(5, k) = k * (k - 1);
  }
  conditions(0, 0) = conditions(2, 1) = 1;
  if (quintic) conditions(4, 2) = 2;
  const auto lu = conditions.fullPivLu();
  for (Eigen::Index i = 0; i < out.size(); ++i) {
    const auto j = static_cast<std::size_t>(i);
    Eigen::VectorXd at(n);
    at(0) = 0;
    at(1) = b.position_rad[j] - a.position_rad[j];
    at(2) = T * a.velocity_rad_s[j];
    at(3) = T * b.velocity_rad_s[j];
    if (quintic) {
      at(4) = T * T * a.acceleration_rad_s2[j];
      at(5) = T * T * b.acceleration_rad_s2[j];
    }
    const Eigen::VectorXd c = lu.solve(at);
    double q = 0;
    for (int k = n - 1; k >= 0; --k) q = q * (t / T) + c(k);
    out(i) = a.position_rad[j] + q;
  }
  return out;
}

class TimedStream : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    rig.ready();
    ASSERT_EQ(rig.claim(), "");
  }
  api::TrajectoryPoint rest_point() {
    const std::vector<double> zero(static_cast<std::size_t>(rig.dof()), 0.0);
    return {SimTime(0), values_of(rig.controller().reference()), zero, zero};
  }
  std::string append(std::vector<api::TrajectoryPoint> points, bool begins = false) {
    return rig.send(api::AppendPoints{rig.stream, begins, std::move(points)});
  }
  /// Follows one point, at a speed, and the stop behind it; returns the point.
  api::TrajectoryPoint follow_until_moving(SimTime time) {
    auto point = rest_point();
    point.acceleration_rad_s2.clear();
    point.time = time;
    point.position_rad[0] += 0.1;
    point.velocity_rad_s[0] = 0.4;
    EXPECT_EQ(append({point}), "");
    rig.forget();
    rig.finish();
    EXPECT_GT(rig.controller().reference()(0), point.position_rad[0]);
    EXPECT_LE(rig.effort().accel, 1.2);
    return point;
  }
  StreamRig rig{GetParam()};
};

TEST_P(TimedStream, FollowsTheClosedFormAtEveryStep) {
  std::mt19937 engine(7);
  for (const bool accelerations : {false, true}) {
    for (const double period : {0.1, 0.004, 0.0375}) {
      std::vector<api::TrajectoryPoint> all{rest_point()};
      if (!accelerations) all[0].acceleration_rad_s2.clear();
      const auto points = smooth_points(rig, engine, 30, period, 0.8, accelerations);
      all.insert(all.end(), points.begin(), points.end());
      rig.forget();
      ASSERT_EQ(append(points, true), "");
      rig.finish();
      std::size_t segment = 0;
      double worst = 0;
      for (std::size_t k = 1; k < rig.path().size(); ++k) {
        const SimTime now = milliseconds(k);
        while (segment + 2 < all.size() && all[segment + 1].time <= now) ++segment;
        const double t = std::min(seconds(now - all[segment].time),
                                  seconds(all[segment + 1].time - all[segment].time));
        const JointVector expected = closed_form(all[segment], all[segment + 1], t);
        worst = std::max(worst, (rig.path()[k] - expected).cwiseAbs().maxCoeff());
      }
      EXPECT_LE(worst, 1e-12) << period << (accelerations ? " quintic" : " cubic");
      EXPECT_EQ(rig.controller().reference(), vector_of(points.back().position_rad));
      EXPECT_EQ(rig.motion().time, points.back().time);
      EXPECT_EQ(rig.motion().phase, Phase::kReady);
    }
  }
}

TEST_P(TimedStream, PointsThatAreAppendedOnTheWayGiveTheSameMotion) {
  std::mt19937 engine(3);
  const auto points = smooth_points(rig, engine, 40, 0.02, 0.8, false);
  StreamRig other(GetParam());
  other.ready();
  ASSERT_EQ(other.claim(), "");
  rig.forget();
  other.forget();
  ASSERT_EQ(append(points), "");
  for (std::size_t i = 0; i < points.size(); ++i) {
    // Each one while the curve before it runs.
    ASSERT_EQ(other.send(api::AppendPoints{other.stream, i == 0, {points[i]}}), "") << i;
    if (i > 0) other.steps(20);
  }
  rig.finish();
  other.finish();
  const std::size_t size = std::min(rig.path().size(), other.path().size());
  ASSERT_GT(size, 700u);
  for (std::size_t k = 0; k < size; ++k) ASSERT_EQ(rig.path()[k], other.path()[k]) << k;
}

TEST_P(TimedStream, RandomTrajectoriesWithinTheLimitsAreFollowed) {
  std::mt19937 engine(11);
  for (int i = 0; i < 30; ++i) {
    const double period = std::uniform_real_distribution(0.004, 0.3)(engine);
    const int count = std::uniform_int_distribution(20, 60)(engine);
    const auto points = smooth_points(rig, engine, count, period, 0.9, i % 2 == 0);
    rig.forget();
    ASSERT_EQ(append(points, true), "") << i;
    rig.finish();
    ASSERT_EQ(rig.controller().reference(), vector_of(points.back().position_rad)) << i;
    EXPECT_LE(rig.effort().speed, 1 + 1e-9) << i;
  }
  EXPECT_EQ(rig.motion().alarm, "");
}

TEST_P(TimedStream, APointBeyondALimitIsAnAlarmThatNamesIt) {
  struct Case {
    const char* what;
    void (*spoil)(api::TrajectoryPoint&, const StreamRig&);
  };
  const Case cases[] = {
      {"position",
       [](api::TrajectoryPoint& point, const StreamRig& r) {
         point.time = std::chrono::seconds(20);
         point.position_rad[1] = r.limits().upper(1) + 0.01;
         point.velocity_rad_s.assign(point.velocity_rad_s.size(), 0.0);
       }},
      {"speed", [](api::TrajectoryPoint& point,
                   const StreamRig& r) { point.velocity_rad_s[1] = r.limits().speed(1) * 1.01; }},
      {"torque",
       [](api::TrajectoryPoint& point, const StreamRig& r) {
         point.velocity_rad_s[1] = r.limits().speed(1) * 0.9;
         point.time = milliseconds(105);
       }},
  };
  for (const Case& each : cases) {
    if (rig.motion().stream == 0) {
      ASSERT_EQ(rig.claim(api::StreamMode::kTimed, true), "") << each.what;
    }
    auto point = rest_point();
    point.acceleration_rad_s2.clear();
    point.time = milliseconds(100);
    point.position_rad[0] += 0.01;
    ASSERT_EQ(append({point}), "") << each.what;
    rig.steps(50);
    each.spoil(point, rig);
    if (point.time == milliseconds(100)) point.time = milliseconds(200);
    const std::string error = append({point});
    EXPECT_NE(error.find(each.what), std::string::npos) << error;
    // The torque may be beyond the limit at a joint beside the one that moves.
    const bool names_joint = error.find(rig.model().joints[1].name) != std::string::npos;
    EXPECT_TRUE(names_joint || each.what == std::string("torque")) << error;
    EXPECT_NE(error.find("limit"), std::string::npos) << error;
    EXPECT_EQ(rig.last_end().result, api::StreamResult::kAlarm);
    EXPECT_NE(rig.motion().alarm, "");
    EXPECT_EQ(rig.motion().phase, Phase::kNone);
    rig.rest();
    EXPECT_FALSE(rig.controller().moving());
    EXPECT_NE(rig.claim().find("alarm: "), std::string::npos);
  }
}

TEST_P(TimedStream, MalformedPointsChangeNothing) {
  auto point = rest_point();
  point.time = milliseconds(100);
  ASSERT_EQ(append({point}), "");
  const auto refused = [&](api::TrajectoryPoint bad, const std::string& what) {
    const std::string error = append({std::move(bad)});
    EXPECT_NE(error.find(what), std::string::npos) << error;
    EXPECT_EQ(rig.motion().points_left, 1u);
    EXPECT_EQ(rig.motion().alarm, "");
  };
  auto late = point;
  refused(late, "point 1: time 0.1 s, must be above 0.1 s");
  late.time = milliseconds(200);
  auto bad = late;
  bad.position_rad.pop_back();
  refused(bad, "must be one for each of " + std::to_string(rig.dof()) + " joints");
  bad = late;
  bad.velocity_rad_s.push_back(0);
  refused(bad, "velocities");
  bad = late;
  bad.velocity_rad_s.clear();
  refused(bad, "accelerations without velocities");
  bad = late;
  bad.time = std::chrono::hours(5);
  refused(bad, "at most 14400 s");
  EXPECT_NE(append({late}, true).find("1 points of a trajectory are left"), std::string::npos);
  rig.finish();
  auto elsewhere = rest_point();
  elsewhere.position_rad[0] += 0.011;
  EXPECT_NE(append({elsewhere}, true).find("the robot is at"), std::string::npos);
}

TEST_P(TimedStream, APointAtTheStartMovesNothing) {
  const JointVector here = rig.controller().reference();
  auto point = rest_point();
  point.position_rad[0] += 0.005;
  ASSERT_EQ(append({point}), "");
  rig.steps(50);
  EXPECT_EQ(rig.controller().reference(), here);
  EXPECT_EQ(rig.motion().phase, Phase::kReady);
}

TEST_P(TimedStream, StopsInTheMiddleAndStartsAnew) {
  std::mt19937 engine(5);
  ASSERT_EQ(append(smooth_points(rig, engine, 40, 0.05, 0.9, false)), "");
  rig.steps(437);
  ASSERT_TRUE(rig.controller().moving());
  rig.forget();
  ASSERT_EQ(rig.send(api::StopStream{rig.stream}), "");
  EXPECT_EQ(rig.motion().phase, Phase::kStopping);
  EXPECT_EQ(rig.motion().points_left, 0u);
  EXPECT_NE(append(smooth_points(rig, engine, 10, 0.05, 0.5, false)).find("still stopping"),
            std::string::npos);
  rig.finish();
  EXPECT_EQ(rig.motion().phase, Phase::kReady);
  EXPECT_EQ(rig.motion().stream, rig.stream);
  EXPECT_LE(rig.effort().accel, 1.5) << "stops within the joints' limits";
  const auto points = smooth_points(rig, engine, 10, 0.05, 0.5, false);
  ASSERT_EQ(append(points), "");
  rig.finish();
  EXPECT_EQ(rig.controller().reference(), vector_of(points.back().position_rad));
}

TEST_P(TimedStream, APauseKeepsThePathAndThePoints) {
  std::mt19937 engine(9);
  const auto points = smooth_points(rig, engine, 40, 0.05, 0.5, false);
  StreamRig free(GetParam());
  free.ready();
  ASSERT_EQ(free.claim(), "");
  free.forget();
  rig.forget();
  ASSERT_EQ(free.send(api::AppendPoints{free.stream, true, points}), "");
  ASSERT_EQ(append(points), "");
  free.finish();
  rig.steps(500);
  ASSERT_EQ(rig.send(api::PauseStream{rig.stream, true}), "");
  rig.steps(1500);
  EXPECT_EQ(rig.motion().phase, Phase::kPaused);
  EXPECT_FALSE(rig.controller().moving());
  const JointVector stands = rig.controller().reference();
  rig.steps(100);
  EXPECT_EQ(rig.controller().reference(), stands);
  ASSERT_EQ(rig.send(api::PauseStream{rig.stream, false}), "");
  rig.finish();
  EXPECT_EQ(rig.controller().reference(), vector_of(points.back().position_rad));
  // Every posture is on the way between two of the motion without a pause.
  double spacing = 0;
  for (std::size_t k = 1; k < free.path().size(); ++k) {
    spacing = std::max(spacing, (free.path()[k] - free.path()[k - 1]).cwiseAbs().maxCoeff());
  }
  for (std::size_t k = 0; k < rig.path().size(); k += 10) {
    double nearest = 1;
    for (const JointVector& q : free.path()) {
      nearest = std::min(nearest, (q - rig.path()[k]).cwiseAbs().maxCoeff());
    }
    ASSERT_LE(nearest, 0.51 * spacing) << k;
  }
  EXPECT_LE(rig.effort().accel, 1.3);
}

TEST_P(TimedStream, PointsInPlaceOfOthersBeginOnTheirCurve) {
  std::mt19937 engine(12);
  for (int round = 0; round < 40; ++round) {
    StreamRig cut(GetParam()), whole(GetParam());
    for (StreamRig* each : {&cut, &whole}) {
      each->ready();
      ASSERT_EQ(each->claim(), "");
    }
    const auto points = smooth_points(cut, engine, 20, 0.05, 0.5, round % 2 == 0);
    const int sent_at = std::uniform_int_distribution(100, 700)(engine);
    const int ends_at = sent_at + std::uniform_int_distribution(-50, 100)(engine);
    for (StreamRig* each : {&cut, &whole}) {
      ASSERT_EQ(each->send(api::AppendPoints{each->stream, true, points}), "");
      each->steps(sent_at);
      each->forget();
    }
    // The earliest end is a millisecond from now.
    const int left = std::max(ends_at - sent_at, 1);
    whole.steps(left + 1);
    const auto& path = whole.path();
    const auto at = static_cast<std::size_t>(left);
    const JointVector speed = (path[at + 1] - path[at - 1]) / 2e-3;
    const std::vector<double> rest(static_cast<std::size_t>(cut.dof()), 0.0);
    const JointVector stop = path[at] + 0.1 * speed;
    const api::TrajectoryPoint point{milliseconds(sent_at + left + 200), values_of(stop), rest, {}};
    ASSERT_EQ(cut.send(api::AppendPoints{cut.stream, false, {point}, milliseconds(ends_at)}), "");
    EXPECT_EQ(cut.motion().end_time, point.time);
    cut.finish();
    for (std::size_t k = 0; k <= at; ++k) {
      ASSERT_LE((cut.path()[k] - path[k]).cwiseAbs().maxCoeff(), 1e-12) << round << " " << k;
    }
    EXPECT_LE(cut.effort().accel, 1) << round << ": no jump of the speed";
    EXPECT_EQ(cut.controller().reference(), stop) << round;
  }
}

TEST_P(TimedStream, ARefusedPointInPlaceOfOthersChangesNothing) {
  std::mt19937 engine(13);
  const auto points = smooth_points(rig, engine, 20, 0.05, 0.5, false);
  ASSERT_EQ(append(points, true), "");
  rig.steps(300);
  const auto left = rig.motion().points_left;
  auto point = points[10];
  point.time = milliseconds(301);
  const std::string error =
      rig.send(api::AppendPoints{rig.stream, false, {point}, milliseconds(100)});
  EXPECT_NE(error.find("time 0.301 s, must be above 0.301 s"), std::string::npos) << error;
  EXPECT_EQ(rig.motion().points_left, left);
  EXPECT_EQ(rig.motion().end_time, points.back().time);
  EXPECT_EQ(rig.motion().alarm, "");
  rig.finish();
  EXPECT_EQ(rig.controller().reference(), vector_of(points.back().position_rad));
}

TEST_P(TimedStream, APauseMayEndTheCurve) {
  for (const bool quintic : {false, true}) {
    StreamRig cut(GetParam()), whole(GetParam());
    std::mt19937 engine(10);
    for (StreamRig* each : {&cut, &whole}) {
      each->ready();
      ASSERT_EQ(each->claim(), "");
    }
    const auto points = smooth_points(cut, engine, 20, 0.05, 0.5, quintic);
    for (StreamRig* each : {&cut, &whole}) {
      ASSERT_EQ(each->send(api::AppendPoints{each->stream, true, points}), "");
    }
    cut.steps(200);
    whole.steps(200);
    // Between two points; those behind are dropped.
    ASSERT_EQ(cut.send(api::PauseStream{cut.stream, false, milliseconds(620)}), "");
    EXPECT_EQ(cut.motion().points_left, 9u);
    EXPECT_EQ(cut.motion().end_time, milliseconds(620));
    for (int k = 200; k < 620; ++k) {
      cut.steps(1);
      whole.steps(1);
      const JointVector error = cut.controller().reference() - whole.controller().reference();
      ASSERT_LE(error.cwiseAbs().maxCoeff(), 1e-12) << k;
    }
    EXPECT_EQ(cut.motion().points_left, 0u);
    cut.finish();
    EXPECT_EQ(cut.motion().time, milliseconds(620));
    // A time behind the end changes nothing; one that has passed ends it in the next step.
    ASSERT_EQ(whole.send(api::PauseStream{whole.stream, false, milliseconds(5000)}), "");
    EXPECT_EQ(whole.motion().end_time, points.back().time);
    ASSERT_EQ(whole.send(api::PauseStream{whole.stream, false, milliseconds(1)}), "");
    EXPECT_EQ(whole.motion().points_left, 1u);
    whole.steps(1);
    EXPECT_EQ(whole.motion().points_left, 0u);
  }
}

TEST_P(TimedStream, PointsThatEndAtASpeedAreFollowedByAStop) {
  auto point = follow_until_moving(milliseconds(500));
  // Time stands meanwhile, and the next point goes on from there.
  EXPECT_EQ(rig.motion().time, milliseconds(500));
  point.time = milliseconds(1500);
  point.velocity_rad_s[0] = 0;
  ASSERT_EQ(append({point}), "");
  rig.steps(999);
  EXPECT_EQ(rig.motion().points_left, 1u);
  rig.steps(1);
  EXPECT_EQ(rig.motion().points_left, 0u);
  EXPECT_EQ(rig.controller().reference(), vector_of(point.position_rad));
}

TEST_P(TimedStream, AnEndAtASpeedWithinAStepIsNoJerk) {
  // A quarter of the last step belongs to the curve.
  follow_until_moving(std::chrono::microseconds(499'250));
}

TEST_P(TimedStream, IncrementsMayBeFedAsLines) {
  const JointVector start = rig.controller().reference();
  for (int k = 1; k <= 100; ++k) {
    JointVector q = start;
    q(0) += 1e-4 * k;
    ASSERT_EQ(append({{milliseconds(4 * k), values_of(q), {}, {}}}), "");
  }
  rig.forget();
  rig.finish();
  EXPECT_NEAR(rig.path()[202](0), start(0) + 1e-4 * 50.5, 1e-12);
  EXPECT_NEAR(rig.controller().reference()(0), start(0) + 1e-2, 1e-15);
}

TEST_P(TimedStream, TooManyPointsAreRefused) {
  std::vector<api::TrajectoryPoint> points;
  for (std::size_t k = 1; k <= api::kMaxTrajectoryPoints; ++k) {
    points.push_back(rest_point());
    points.back().time = milliseconds(k);
  }
  ASSERT_EQ(append(points), "");
  auto more = rest_point();
  more.time = std::chrono::seconds(100);
  EXPECT_NE(append({more}).find("the limit is 4000"), std::string::npos);
}

TEST_P(TimedStream, AnOverrideSlowsTheTime) {
  std::mt19937 engine(13);
  const auto points = smooth_points(rig, engine, 20, 0.05, 0.5, false);
  rig.apply(api::SetOverride{0.5});
  ASSERT_EQ(append(points), "");
  int steps = 0;
  for (; rig.motion().phase != Phase::kReady && steps < 10000; ++steps) rig.step();
  EXPECT_NEAR(steps, 2000, 30);
  EXPECT_EQ(rig.controller().reference(), vector_of(points.back().position_rad));
}

INSTANTIATE_TEST_SUITE_P(Arms, TimedStream, testing::Values("fanuc", "motoman"));

}  // namespace
}  // namespace aprsim::robot
