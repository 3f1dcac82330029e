#include "world/robot/trajectory/profile/double_s.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace aprsim::robot {
namespace {

struct Extremes {
  double v = 0, a = 0, j = 0;
  double s_min = 0, s_max = 0;
  double v_min = 0;
  double jump_s = 0, jump_v = 0, jump_a = 0;  ///< between neighbouring samples beyond the limits
};

Extremes sample(const DoubleS& plan, const ScalarLimits& limits, int count) {
  Extremes out;
  const double dt = plan.duration() / count;
  ScalarState last = plan.at(0);
  out.s_min = out.s_max = last.s;
  out.v = std::abs(last.v);
  out.a = std::abs(last.a);
  out.v_min = last.v;
  for (int i = 1; i <= count; ++i) {
    const ScalarState x = plan.at(i * dt);
    out.v = std::max(out.v, std::abs(x.v));
    out.a = std::max(out.a, std::abs(x.a));
    out.v_min = std::min(out.v_min, x.v);
    out.s_min = std::min(out.s_min, x.s);
    out.s_max = std::max(out.s_max, x.s);
    out.jump_a = std::max(out.jump_a, std::abs(x.a - last.a) - limits.j * dt);
    const double mean_v = (x.v + last.v) / 2;
    out.jump_s =
        std::max(out.jump_s, std::abs(x.s - last.s - mean_v * dt) - limits.j * dt * dt * dt);
    const double mean_a = (x.a + last.a) / 2;
    out.jump_v = std::max(out.jump_v, std::abs(x.v - last.v - mean_a * dt) - limits.j * dt * dt);
    last = x;
  }
  return out;
}

class Draw {
 public:
  explicit Draw(unsigned seed) : engine_(seed) {}
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  /// Spread over orders of magnitude.
  double scale(double low, double high) { return std::exp(uniform(std::log(low), std::log(high))); }
  ScalarLimits limits() { return {scale(0.01, 10), scale(0.05, 50), scale(0.5, 500)}; }
  /// A state from which the speed limit can still be kept: |v + a|a|/2j| <= v_max.
  ScalarState state(const ScalarLimits& l) {
    for (;;) {
      const ScalarState x{uniform(-3, 3), uniform(-l.v, l.v), uniform(-l.a, l.a)};
      if (std::abs(x.v + x.a * std::abs(x.a) / (2 * l.j)) <= l.v) return x;
    }
  }

 private:
  std::mt19937 engine_;
};

TEST(DoubleS, KeepsItsLimitsAndEndsExactlyFromRandomStates) {
  Draw draw(1);
  for (int i = 0; i < 20000; ++i) {
    const auto l = draw.limits();
    const auto x = draw.state(l);
    const double goal = x.s + draw.uniform(-2, 2);
    const auto plan = DoubleS::to_rest(x, goal, l);
    const auto seen = sample(plan, l, 200);
    ASSERT_LE(seen.v, l.v * (1 + 1e-9)) << i;
    ASSERT_LE(seen.a, l.a * (1 + 1e-9)) << i;
    ASSERT_LE(seen.jump_a, 1e-9 * l.a) << i;
    ASSERT_LE(seen.jump_v, 1e-9 * l.v) << i;
    ASSERT_LE(seen.jump_s, 1e-9) << i;
    EXPECT_EQ(plan.at(plan.duration()).s, goal);
    EXPECT_EQ(plan.at(plan.duration()).v, 0.0);
    EXPECT_EQ(plan.at(plan.duration() + 1).a, 0.0);
    // The polynomial itself must arrive, not only the final value.
    const auto before = plan.at(std::nextafter(plan.duration(), 0.0));
    ASSERT_NEAR(before.s, goal, 1e-11) << i;
    ASSERT_NEAR(before.v, 0, 1e-9 * l.v) << i;
    ASSERT_NEAR(before.a, 0, 1e-9 * l.a) << i;
    EXPECT_EQ(plan.at(0).s, x.s);
    EXPECT_EQ(plan.at(0).v, x.v);
  }
}

TEST(DoubleS, NeverOvershootsOrReversesWhenThereIsRoomToStop) {
  Draw draw(2);
  int tried = 0;
  for (int i = 0; i < 20000; ++i) {
    const auto l = draw.limits();
    auto x = draw.state(l);
    // Moving forward, and still forward once the acceleration has been brought to zero.
    if (x.v < 0 || x.v + x.a * std::abs(x.a) / (2 * l.j) < 0) continue;
    const double stop = DoubleS::stop(x, l).end();
    const double goal = stop + draw.uniform(0, 2);
    const auto plan = DoubleS::to_rest(x, goal, l);
    const auto seen = sample(plan, l, 200);
    ASSERT_LE(seen.s_max, goal + 1e-11) << i;
    ASSERT_GE(seen.v_min, -1e-9 * l.v) << i;
    ++tried;
  }
  EXPECT_GT(tried, 5000);
}

TEST(DoubleS, RestToRestIsAsQuickAsTheLimitsAllow) {
  Draw draw(3);
  for (int i = 0; i < 5000; ++i) {
    const auto l = draw.limits();
    const double d = draw.scale(1e-6, 10);
    const auto plan = DoubleS::to_rest({0, 0, 0}, d, l);
    // Closed form: reach the speed limit or not, the acceleration limit or not.
    const double v_full = l.a * l.a / l.j;
    auto ramp = [&](double v) {
      return v >= v_full ? v / l.a + l.a / l.j : 2 * std::sqrt(v / l.j);
    };
    double time = 0;
    if (l.v * ramp(l.v) <= d) {
      time = 2 * ramp(l.v) + (d - l.v * ramp(l.v)) / l.v;
    } else if (v_full * ramp(v_full) <= d) {
      const double b = l.a * l.a / l.j;
      const double v = (-b + std::sqrt(b * b + 4 * l.a * d)) / 2;
      time = 2 * ramp(v);
    } else {
      time = 4 * std::cbrt(d / (2 * l.j));
    }
    ASSERT_NEAR(plan.duration(), time, 1e-9 * time) << i;
  }
}

TEST(DoubleS, StopsFromAnyStateWithinLimits) {
  Draw draw(4);
  for (int i = 0; i < 20000; ++i) {
    const auto l = draw.limits();
    const auto x = draw.state(l);
    const auto plan = DoubleS::stop(x, l);
    const auto seen = sample(plan, l, 100);
    ASSERT_LE(seen.a, l.a * (1 + 1e-9));
    ASSERT_LE(seen.jump_a, 1e-9 * l.a);
    const auto before = plan.at(std::nextafter(plan.duration(), 0.0));
    ASSERT_NEAR(before.s, plan.end(), 1e-11);
    ASSERT_NEAR(before.v, 0, 1e-9 * l.v);
    EXPECT_EQ(plan.at(plan.duration()).s, plan.end());
  }
}

TEST(DoubleS, ReturnsFromBeyondTheLimits) {
  const ScalarLimits l{0.5, 2, 20};
  const auto plan = DoubleS::to_rest({0, 1.5, 5}, 3, l);
  const auto seen = sample(plan, l, 1000);
  EXPECT_LE(seen.jump_a, 1e-9);
  EXPECT_NEAR(plan.at(std::nextafter(plan.duration(), 0.0)).s, 3, 1e-11);
  const auto late = plan.at(2.5);
  EXPECT_LE(late.v, 0.5 + 1e-12);
  EXPECT_LE(std::abs(late.a), 2 + 1e-12);
}

TEST(DoubleS, GoesBackWhenTooFastToStop) {
  const ScalarLimits l{1, 2, 20};
  const auto plan = DoubleS::to_rest({0, 1, 0}, 0.01, l);
  const auto seen = sample(plan, l, 1000);
  EXPECT_GT(seen.s_max, 0.2);
  EXPECT_EQ(plan.at(plan.duration()).s, 0.01);
  EXPECT_NEAR(plan.at(std::nextafter(plan.duration(), 0.0)).s, 0.01, 1e-11);
}

TEST(DoubleS, NothingToDoTakesNoTime) {
  const auto plan = DoubleS::to_rest({0.3, 0, 0}, 0.3, {1, 1, 1});
  EXPECT_EQ(plan.duration(), 0.0);
  EXPECT_EQ(plan.at(0).s, 0.3);
  EXPECT_EQ(DoubleS::stop({0.3, 0, 0}, {1, 1, 1}).end(), 0.3);
}

}  // namespace
}  // namespace aprsim::robot
