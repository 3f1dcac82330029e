#include <cmath>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/sweep/distribution.hpp"
#include "clients/aprsim/sweep/sweep_report.hpp"

namespace aprsim::client {
namespace {

// Values and t quantile (2.776 for 4 degrees of freedom) as in any table.
TEST(Distribution, OfFiveValues) {
  const Distribution d = distribution_of({5, 1, 4, 2, 3});
  EXPECT_EQ(d.count, 5U);
  EXPECT_DOUBLE_EQ(d.mean, 3);
  EXPECT_NEAR(d.deviation, std::sqrt(2.5), 1e-12);
  EXPECT_NEAR(d.mean_95.high - 3, 2.776445 * std::sqrt(2.5) / std::sqrt(5), 1e-5);
  EXPECT_NEAR(3 - d.mean_95.low, d.mean_95.high - 3, 1e-12);
  EXPECT_DOUBLE_EQ(d.median, 3);
  EXPECT_DOUBLE_EQ(d.p05, 1.2);
  EXPECT_DOUBLE_EQ(d.p95, 4.8);
  EXPECT_DOUBLE_EQ(d.min, 1);
  EXPECT_DOUBLE_EQ(d.max, 5);
}

TEST(Distribution, OfOneValueIsThatValue) {
  const Distribution d = distribution_of({7});
  EXPECT_EQ(d.mean_95.low, 7);
  EXPECT_EQ(d.mean_95.high, 7);
  EXPECT_EQ(d.p95, 7);
  EXPECT_EQ(d.deviation, 0);
}

// Wilson's interval for 50 of 50 is 1 / (1 + z^2 / n) at its lower end.
TEST(Distribution, ShareOfAllAndOfHalf) {
  EXPECT_NEAR(share_95(50, 50).low, 1 / (1 + 1.959964 * 1.959964 / 50), 1e-6);
  EXPECT_DOUBLE_EQ(share_95(50, 50).high, 1);
  EXPECT_NEAR(share_95(5, 10).low, 0.2366, 1e-4);
  EXPECT_NEAR(share_95(5, 10).high, 0.7634, 1e-4);
  EXPECT_DOUBLE_EQ(share_95(0, 10).low, 0);
}

SweepRun run(std::uint64_t seed, double time_s) {
  return {.seed = seed,
          .as_expected = time_s < 60,
          .ended = "all orders were submitted",
          .values = {{"time", time_s}},
          .state_hash = "00ff"};
}

TEST(SweepReport, TheOrderOfRunsMakesNoDifference) {
  const SweepRun lost{.seed = 3, .failure = "the daemon does not serve"};
  const Sweep one{"clean", {run(1, 58.3), run(2, 61.7), lost, run(4, 57.1)}};
  const Sweep other{"clean", {lost, run(4, 57.1), run(2, 61.7), run(1, 58.3)}};
  EXPECT_EQ(sweep_json(one).dump(1), sweep_json(other).dump(1));
  EXPECT_EQ(sweep_table(one), sweep_table(other));
}

TEST(SweepReport, TellsSharesMeasuresAndWhatWentWrong) {
  const SweepRun lost{.seed = 3, .failure = "the daemon does not serve"};
  const Sweep sweep{"clean", {run(1, 58), run(2, 61), lost}};
  const auto json = sweep_json(sweep);
  EXPECT_EQ(json["runs"], 3);
  EXPECT_EQ(json["failed"], 1);
  EXPECT_EQ(json["as_expected"], 1);
  EXPECT_EQ(json["measures"]["time"]["runs"], 2);
  EXPECT_EQ(json["measures"]["time"]["mean"], 59.5);
  EXPECT_EQ(json["each"][2]["failure"], "the daemon does not serve");
  const std::string table = sweep_table(sweep);
  EXPECT_NE(table.find("3 runs, 1 as expected"), std::string::npos) << table;
  EXPECT_NE(table.find("seed 2: not as expected"), std::string::npos) << table;
  EXPECT_NE(table.find("seed 3: the daemon does not serve"), std::string::npos) << table;
}

}  // namespace
}  // namespace aprsim::client
