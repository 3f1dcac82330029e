#include "world/robot/trajectory/time_scaling.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace aprsim::robot {
namespace {

TEST(TimeScaling, WithoutKnotsIsTheIdentity) {
  TimeScaling stretch;
  EXPECT_EQ(stretch.length(), 1.0);
  EXPECT_EQ(stretch.u_at(0.3), 0.3);
  EXPECT_EQ(stretch.u_at(2), 1.0);
}

TEST(TimeScaling, KeepsRatesAndSlopes) {
  std::mt19937 engine(4);
  std::uniform_real_distribution<double> gap(1e-4, 0.02), rate(0.02, 1.5), slope(0.5, 20);
  for (int n = 0; n < 50; ++n) {
    std::vector<TimeScaling::Knot> knots;
    for (double u = 0; u < 1; u += gap(engine)) knots.push_back({u, rate(engine), slope(engine)});
    knots.push_back({1, rate(engine), slope(engine)});
    TimeScaling stretch;
    stretch.build(knots);
    EXPECT_GE(stretch.length(), 1.0 - 1e-12);
    EXPECT_EQ(stretch.u_at(0), 0.0);
    EXPECT_NEAR(stretch.u_at(stretch.length()), 1.0, 1e-12);
    const int count = 5000;
    const double h = stretch.length() / count;
    double last_u = 0, last_rate = stretch.rate_at(0);
    std::size_t k = 0;
    for (int i = 1; i <= count; ++i) {
      const double u = stretch.u_at(i * h), r = stretch.rate_at(i * h);
      ASSERT_GE(u, last_u);
      ASSERT_NEAR((u - last_u) / h, (r + last_rate) / 2, 0.02);
      while (k + 2 < knots.size() && knots[k + 1].u <= u) ++k;
      ASSERT_LE(r, std::max({knots[k].rate, knots[k + 1].rate}) + 1e-9);
      ASSERT_LE(r, 1 + 1e-12);
      ASSERT_LE(std::abs(r - last_rate), 20 * h * (1 + 1e-9));
      last_u = u;
      last_rate = r;
    }
  }
}

TEST(TimeScaling, DoesNotSlowWhereNothingAsksForIt) {
  std::vector<TimeScaling::Knot> knots;
  for (int i = 0; i <= 100; ++i) knots.push_back({i / 100.0, i == 50 ? 0.2 : 1.0, 4.0});
  TimeScaling stretch;
  stretch.build(knots);
  EXPECT_EQ(stretch.rate_at(0), 1.0);
  EXPECT_EQ(stretch.rate_at(0.2), 1.0);
  double lowest = 1;
  for (int i = 0; i <= 10000; ++i) {
    lowest = std::min(lowest, stretch.rate_at(i * 1e-4 * stretch.length()));
  }
  EXPECT_NEAR(lowest, 0.2, 1e-3);
}

}  // namespace
}  // namespace aprsim::robot
