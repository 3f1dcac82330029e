#include "world/robot/trajectory/profile/time_scaling.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace aprsim::robot {
namespace {

TEST(TimeScaling, WithoutLimitsIsTheIdentity) {
  TimeScaling scaling;
  EXPECT_EQ(scaling.length(), 1.0);
  EXPECT_EQ(scaling.u_at(0.3), 0.3);
  EXPECT_EQ(scaling.u_at(2), 1.0);
}

TEST(TimeScaling, KeepsRatesAndSlopes) {
  std::mt19937 engine(4);
  std::uniform_real_distribution<double> gap(1e-4, 0.02), rate(0.02, 1.5), slope(0.5, 20);
  for (int n = 0; n < 50; ++n) {
    std::vector<TimeScaling::RateLimit> limits;
    for (double u = 0; u < 1; u += gap(engine)) limits.push_back({u, rate(engine), slope(engine)});
    limits.push_back({1, rate(engine), slope(engine)});
    TimeScaling scaling;
    scaling.build(limits);
    EXPECT_GE(scaling.length(), 1.0 - 1e-12);
    EXPECT_EQ(scaling.u_at(0), 0.0);
    EXPECT_NEAR(scaling.u_at(scaling.length()), 1.0, 1e-12);
    const int count = 5000;
    const double h = scaling.length() / count;
    double last_u = 0, last_rate = scaling.rate_at(0);
    std::size_t k = 0;
    for (int i = 1; i <= count; ++i) {
      const double u = scaling.u_at(i * h), r = scaling.rate_at(i * h);
      ASSERT_GE(u, last_u);
      ASSERT_NEAR((u - last_u) / h, (r + last_rate) / 2, 0.02);
      while (k + 2 < limits.size() && limits[k + 1].u <= u) ++k;
      ASSERT_LE(r, std::max({limits[k].rate, limits[k + 1].rate}) + 1e-9);
      ASSERT_LE(r, 1 + 1e-12);
      ASSERT_LE(std::abs(r - last_rate), 20 * h * (1 + 1e-9));
      last_u = u;
      last_rate = r;
    }
  }
}

TEST(TimeScaling, DoesNotSlowWhereNothingAsksForIt) {
  std::vector<TimeScaling::RateLimit> limits;
  for (int i = 0; i <= 100; ++i) limits.push_back({i / 100.0, i == 50 ? 0.2 : 1.0, 4.0});
  TimeScaling scaling;
  scaling.build(limits);
  EXPECT_EQ(scaling.rate_at(0), 1.0);
  EXPECT_EQ(scaling.rate_at(0.2), 1.0);
  double lowest = 1;
  for (int i = 0; i <= 10000; ++i) {
    lowest = std::min(lowest, scaling.rate_at(i * 1e-4 * scaling.length()));
  }
  EXPECT_NEAR(lowest, 0.2, 1e-3);
}

}  // namespace
}  // namespace aprsim::robot
