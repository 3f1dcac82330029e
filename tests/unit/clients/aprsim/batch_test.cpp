#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/batch/batch_report.hpp"
#include "clients/aprsim/batch/batch_results.hpp"
#include "clients/aprsim/batch/distribution.hpp"
#include "clients/aprsim/batch/report_diff.hpp"
#include "clients/aprsim/batch/seeds.hpp"
#include "clients/aprsim/batch/significance.hpp"
#include "tests/support/temporary_directory.hpp"

namespace aprsim::client {
namespace {

// Values and t quantile (2.776 for 4 degrees of freedom) as in any table.
TEST(Distribution, HasTheQuantilesOfFiveValues) {
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

using Seeds = std::vector<std::uint64_t>;

TEST(Seeds, RangesAndSingleOnesRisingAndOnce) {
  EXPECT_EQ(parse_seeds("1..4"), Seeds({1, 2, 3, 4}));
  EXPECT_EQ(parse_seeds("9,2..4,3,20"), Seeds({2, 3, 4, 9, 20}));
  EXPECT_EQ(parse_seeds("18446744073709551615"), Seeds({18446744073709551615U}));
  EXPECT_EQ(parse_seeds("18446744073709551614..18446744073709551615")->size(), 2U);
  for (const char* wrong :
       {"", "1..", "..4", "4..1", "1,,2", "a", "1..2000000", "-1", "1 ", "1..2..3"}) {
    EXPECT_FALSE(parse_seeds(wrong)) << wrong;
  }
  EXPECT_EQ(seeds_text({2, 3, 4, 9, 20, 21}), "2..4,9,20..21");
  EXPECT_EQ(seeds_text({}), "none");
}

TEST(Seeds, EachIsInExactlyOneShard) {
  const auto seeds = *parse_seeds("1..37");
  for (const std::size_t count : {1U, 2U, 5U, 10U, 37U, 50U}) {
    Seeds all;
    for (std::size_t i = 0; i < count; ++i) {
      const auto share = share_of(seeds, {i, count});
      EXPECT_LE(share.size(), 37 / count + 1);
      all.insert(all.end(), share.begin(), share.end());
    }
    std::ranges::sort(all);
    EXPECT_EQ(all, seeds) << count;
  }
  EXPECT_EQ(parse_shard("0/1"), (Shard{0, 1}));
  EXPECT_EQ(parse_shard("9/10"), (Shard{9, 10}));
  for (const char* wrong : {"", "1", "10/10", "-1/3", "1/0", "1/", "/3", "1/3/4"}) {
    EXPECT_FALSE(parse_shard(wrong)) << wrong;
  }
}

// Computed apart: 1 - 6 d^2 / n (n^2 - 1), and Student's t by numerical integration.
TEST(Significance, RankCorrelation) {
  const std::vector<double> x{1, 2, 3, 4, 5, 6, 7, 8}, y{2, 1, 4, 3, 7, 8, 6, 5};
  const Correlation c = rank_correlation(x, y);
  EXPECT_NEAR(c.rho, 0.738095238095238, 1e-12);
  EXPECT_NEAR(c.p, 0.0365527611, 1e-8);
  EXPECT_EQ(rank_correlation(x, std::vector<double>(8, 3)).p, 1);
  EXPECT_EQ(rank_correlation(x, x).rho, 1);
  std::vector<double> reversed(x.rbegin(), x.rend());
  EXPECT_EQ(rank_correlation(x, reversed).rho, -1);
  // The order of the pairs makes no difference to a bit.
  std::vector<double> x2(x.rbegin(), x.rend()), y2(y.rbegin(), y.rend());
  EXPECT_EQ(rank_correlation(x2, y2).rho, c.rho);
}

TEST(Significance, ComparesShares) {
  // The lady tasting tea: 3 of 4 and 1 of 4.
  EXPECT_NEAR(fisher_exact(3, 4, 1, 4), 34.0 / 70, 1e-12);
  EXPECT_NEAR(fisher_exact(10, 10, 4, 10), 0.0108359, 1e-6);
  EXPECT_EQ(fisher_exact(10, 10, 10, 10), 1);
  EXPECT_EQ(fisher_exact(0, 10, 0, 10), 1);
  EXPECT_NEAR(mcnemar_exact(1, 9), 2 * 11.0 / 1024, 1e-12);
  EXPECT_EQ(mcnemar_exact(4, 4), 1);
  EXPECT_EQ(mcnemar_exact(0, 0), 1);
}

TEST(Significance, ComparesDifferencesAndSamples) {
  // All of five positive: 2 / 2^5.
  EXPECT_NEAR(signed_rank(std::vector<double>{1, 2, 3, 4, 5}), 0.0625, 1e-12);
  EXPECT_NEAR(signed_rank(std::vector<double>{-1, 2, 3, 4, 5, 0}), 0.125, 1e-12);
  EXPECT_EQ(signed_rank(std::vector<double>{0, 0}), 1);
  EXPECT_EQ(signed_rank(std::vector<double>{-1, 1}), 1);
  // For many values the normal distribution agrees with the exact one within a few per cent.
  std::vector<double> many;
  for (int i = 1; i <= 60; ++i) many.push_back(i % 3 == 0 ? -i : i);
  const double p = signed_rank(many);
  EXPECT_GT(p, 0.005);
  EXPECT_LT(p, 0.05);
  std::vector<double> a, b;
  for (int i = 0; i < 20; ++i) {
    a.push_back(i);
    b.push_back(i + 8);
  }
  EXPECT_NEAR(rank_sum(a, b), 0.0005588671186, 1e-12);
  EXPECT_GT(rank_sum(a, a), 0.99);
}

TEST(Significance, ManyTests) {
  const std::vector<double> p{0.01, 0.04, 0.03, 0.5};
  const auto fdr = by_false_discovery(p), holm = by_any_error(p);
  EXPECT_NEAR(fdr[0], 0.04, 1e-12);
  EXPECT_NEAR(fdr[1], 0.16 / 3, 1e-12);
  EXPECT_NEAR(fdr[2], 0.16 / 3, 1e-12);
  EXPECT_NEAR(fdr[3], 0.5, 1e-12);
  EXPECT_NEAR(holm[0], 0.04, 1e-12);
  EXPECT_NEAR(holm[1], 0.09, 1e-12);
  EXPECT_NEAR(holm[2], 0.09, 1e-12);
  EXPECT_NEAR(holm[3], 0.5, 1e-12);
}

/// Succeeds while `grip` is small; its time follows nothing.
Episode episode(std::uint64_t seed) {
  const double grip = static_cast<double>(seed * 7 % 100) / 100;
  const double other = static_cast<double>(seed * 37 % 101) / 101;
  const bool good = grip < 0.6;
  Episode out{.seed = seed,
              .as_expected = good,
              .end_reason = "the controller is done",
              .state_hash = "00000000000000ff",
              .values = {{"drops", good ? 0 : 1}, {"run_s", 4 + other}},
              .drawn = {{"grip_share", grip}, {"other_m", other - 0.5}}};
  if (!good) out.broken = {"drops 1, expected 0"};
  return out;
}

Batch batch_of(const Seeds& seeds) {
  Batch out{.identity = {"pick", "a <part>", "pick", "1", "abc"}, .seeds = seeds};
  for (const std::uint64_t seed : seeds) out.episodes.emplace(seed, episode(seed));
  return out;
}

TEST(BatchReport, FindsTheParameterOfSuccess) {
  const Batch batch = batch_of(*parse_seeds("1..100"));
  const auto by = success_by_parameter(batch);
  ASSERT_EQ(by.size(), 2U);
  EXPECT_EQ(by[0].parameter, "grip_share");
  ASSERT_EQ(by[0].bins.size(), 5U);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(by[0].bins[i].runs, 20U);
    EXPECT_EQ(by[0].bins[i].as_expected, i < 3 ? 20U : 0U);
  }
  EXPECT_NEAR(by[0].bins[0].share_95.low, share_95(20, 20).low, 1e-15);
  const auto sensitivities = sensitivity_of(batch);
  ASSERT_FALSE(sensitivities.empty());
  EXPECT_EQ(sensitivities[0].parameter, "other_m") << "the run's time is it, to the bit";
  EXPECT_EQ(sensitivities[0].outcome, "run_s");
  for (const Sensitivity& s : sensitivities) {
    if (s.parameter == "grip_share" && s.outcome == "as_expected") {
      EXPECT_LT(s.rank_correlation, -0.8);
      EXPECT_LT(s.p_adjusted, 1e-9);
    }
    if (s.parameter == "other_m" && s.outcome == "as_expected") {
      EXPECT_GT(s.p_adjusted, 0.05);
    }
  }
}

TEST(BatchReport, ListsWorstRunsWithJournals) {
  Batch batch = batch_of(*parse_seeds("1..50"));
  batch.episodes.at(7).broken = {"drops 1, expected 0", "held_end 0, expected 1"};
  batch.episodes.at(7).as_expected = false;
  batch.journals = {7};
  const auto worst = worst_runs(batch, 3);
  ASSERT_EQ(worst.size(), 3U);
  EXPECT_EQ(worst[0].seed, 7U);
  EXPECT_TRUE(worst[0].journal);
  EXPECT_NE(worst[0].why.find("held_end 0, expected 1"), std::string::npos);
  EXPECT_FALSE(worst[1].journal);
  EXPECT_EQ(worst_seeds(batch, 3).front(), 7U);
  const std::string page = batch_page(batch);
  EXPECT_NE(page.find("href=\"journals/seed_7.journal\""), std::string::npos);
  EXPECT_NE(page.find("a &lt;part&gt;"), std::string::npos);
  EXPECT_NE(page.find("<svg"), std::string::npos);
  EXPECT_NE(batch_table(batch).find("seed 7: "), std::string::npos);
}

/// A batch of runs that are all as expected.
Batch good_batch(const Seeds& seeds) {
  Batch out = batch_of(seeds);
  for (auto& [seed, one] : out.episodes) {
    one.as_expected = true;
    one.broken.clear();
    one.values["drops"] = 0;
  }
  return out;
}

TEST(BatchReport, TheWorstRunsAreThoseThatFailedOrDeviate) {
  Batch batch = good_batch(*parse_seeds("1..40"));
  EXPECT_TRUE(worst_runs(batch, 10).empty());
  EXPECT_EQ(worst_seeds(batch, 2).size(), 2U) << "journals are of the worst of all runs";
  EXPECT_EQ(batch_table(batch).find("worst"), std::string::npos);
  batch.journals = {3};
  EXPECT_EQ(batch_json(batch)["worst"], nlohmann::ordered_json::array());
  EXPECT_EQ(batch_json(batch)["journals"][0]["journal"], "journals/seed_3.journal");
  EXPECT_NE(batch_page(batch).find("href=\"journals/seed_3.journal\""), std::string::npos);
  batch.episodes.at(12).values["drops"] = 2;
  batch.episodes.at(20).values["run_s"] = 40;
  batch.episodes.at(30).as_expected = false;
  batch.episodes.at(30).broken = {"drops 1, expected 0"};
  const auto worst = worst_runs(batch, 10);
  ASSERT_EQ(worst.size(), 3U);
  EXPECT_EQ(worst[0].seed, 30U);
  EXPECT_EQ(worst[0].why, "drops 1, expected 0; the controller is done");
  EXPECT_EQ(worst[1].seed, 20U);
  EXPECT_EQ(worst[1].why.rfind("as expected; run_s 40 s (median 4.", 0), 0U) << worst[1].why;
  EXPECT_EQ(worst[2].seed, 12U);
  EXPECT_EQ(worst[2].why, "as expected; drops 2 (median 0)");
}

TEST(BatchReport, NoHeadingIsEmpty) {
  for (const Batch& batch : {batch_of({}), batch_of({1, 2}), good_batch(*parse_seeds("1..30")),
                             batch_of(*parse_seeds("1..30"))}) {
    const std::string page = batch_page(batch);
    for (auto at = page.find("<h2>"); at != std::string::npos; at = page.find("<h2>", at + 1)) {
      const auto end = page.find("</h2>\n", at) + 6;
      EXPECT_NE(page.compare(end, 4, "<h2>"), 0) << page.substr(at, end - at);
      EXPECT_NE(page.compare(end, 7, "</body>"), 0) << page.substr(at, end - at);
    }
    EXPECT_EQ(page.find("<table><tr><th>seed</th><th>why</th><th>journal</th></tr>\n</table>"),
              std::string::npos);
  }
  // Success that depends on nothing is no plot.
  EXPECT_EQ(batch_page(good_batch(*parse_seeds("1..30"))).find("Success by parameter"),
            std::string::npos);
}

TEST(BatchReport, MeasuresHaveTheirUnitAndBetterSide) {
  const Batch batch = batch_of(*parse_seeds("1..30"));
  const auto json = batch_json(batch);
  EXPECT_EQ(json["measures"]["run_s"]["unit"], "s");
  EXPECT_EQ(json["measures"]["run_s"]["better"], "");
  EXPECT_EQ(json["measures"]["drops"]["unit"], "1");
  EXPECT_EQ(json["measures"]["drops"]["better"], "lower");
  EXPECT_NE(batch_table(batch).find("run_s [s]"), std::string::npos);
  EXPECT_NE(batch_page(batch).find("drops, lower is better"), std::string::npos);
  // Few runs are no distribution.
  EXPECT_EQ(batch_page(batch_of({1, 2, 8})).find("Distributions"), std::string::npos);
}

TEST(BatchReport, SaysWhatItsIntervalIs) {
  EXPECT_NE(batch_table(good_batch(*parse_seeds("1..50")))
                .find("50 runs, 50 as expected; success rate 100.0 %, 95 % confidence interval "
                      "(Wilson) 92.9 to 100.0 %"),
            std::string::npos)
      << batch_table(good_batch(*parse_seeds("1..50")));
}

TEST(Distribution, OfEqualValuesIsExact) {
  const Distribution d = distribution_of(std::vector<double>(50, 14));
  EXPECT_EQ(d.mean, 14);
  EXPECT_EQ(d.deviation, 0);
  EXPECT_EQ(d.mean_95.low, 14);
}

TEST(BatchReport, ReportsEmptyBatchesAndMissingSeeds) {
  Batch batch = batch_of({});
  EXPECT_NE(batch_table(batch).find("0 runs, 0 as expected"), std::string::npos);
  EXPECT_NE(batch_page(batch).find("</html>"), std::string::npos);
  batch = batch_of({1, 2, 3});
  batch.seeds = {1, 2, 3, 4, 6};
  EXPECT_NE(batch_table(batch).find("2 not run: 4,6"), std::string::npos);
  EXPECT_EQ(batch_json(batch)["missing"], nlohmann::ordered_json({4, 6}));
}

std::string text_of_file(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// The batch of a directory whose seeds were shared among `count` tasks.
std::string report_of_shards(const test::TemporaryDirectory& directory, const Seeds& seeds,
                             std::size_t count) {
  std::vector<Batch> batches;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < count; ++i) {
    names.push_back(directory.path() + "/" + std::to_string(count) + "_" + std::to_string(i));
    BatchDirectory shard(names.back());
    const auto share = share_of(seeds, {i, count});
    EXPECT_TRUE(shard.begin(batch_of({}).identity, share));
    for (const std::uint64_t seed : share) EXPECT_TRUE(shard.keep(episode(seed)));
    auto batch = shard.read();
    if (!batch) throw std::runtime_error(batch.error().message);
    batches.push_back(std::move(*batch));
  }
  const auto merged = merge(batches, names);
  if (!merged) throw std::runtime_error(merged.error().message);
  const BatchDirectory whole(directory.path() + "/whole_" + std::to_string(count));
  EXPECT_TRUE(write_report(*merged, whole));
  std::string out;
  for (const char* name : {"report.json", "report.txt", "report.html"}) {
    out += text_of_file(whole.path() / name);
  }
  return out;
}

TEST(BatchDirectory, ShardsGiveTheSameReport) {
  const test::TemporaryDirectory directory;
  const auto seeds = *parse_seeds("1..64,100");
  const std::string one = report_of_shards(directory, seeds, 1);
  EXPECT_GT(one.size(), 10000U);
  EXPECT_EQ(report_of_shards(directory, seeds, 2), one);
  EXPECT_EQ(report_of_shards(directory, seeds, 10), one);
}

TEST(BatchDirectory, ContinuesAnExistingBatch) {
  const test::TemporaryDirectory place;
  BatchDirectory directory(place.path() + "/batch");
  const BatchIdentity identity = batch_of({}).identity;
  ASSERT_TRUE(directory.begin(identity, {1, 2, 3}));
  ASSERT_TRUE(directory.keep(episode(2)));
  // A file cut off by a kill counts as none.
  std::ofstream(directory.path() / "episodes/seed_3.json.77.part") << "{";
  auto again = directory.begin(identity, {3, 4});
  ASSERT_TRUE(again);
  EXPECT_EQ(again->seeds, Seeds({1, 2, 3, 4}));
  ASSERT_EQ(again->episodes.size(), 1U);
  EXPECT_EQ(again->episodes.at(2), episode(2));
  BatchIdentity other = identity;
  other.controller = "another";
  const auto refused = directory.begin(other, {5});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("its controller is pick, not another"), std::string::npos);
  std::ofstream(directory.path() / "episodes/seed_4.json") << "{\"seed\": 4}";
  const auto damaged = directory.read();
  ASSERT_FALSE(damaged);
  EXPECT_NE(damaged.error().message.find("seed_4.json is damaged"), std::string::npos);
}

TEST(BatchDirectory, MergesOnlyEqualIdentities) {
  Batch one = batch_of({1, 2}), other = batch_of({2, 3});
  EXPECT_EQ(merge({one, other}, {"a", "b"})->episodes.size(), 3U);
  other.episodes.at(2).state_hash = "0000000000000001";
  const auto differs = merge({one, other}, {"a", "b"});
  ASSERT_FALSE(differs);
  EXPECT_EQ(differs.error().kind, FailureKind::kCheck);
  EXPECT_NE(differs.error().message.find("seed 2 has different results"), std::string::npos);
  other = batch_of({3});
  other.identity.fingerprint = "def";
  EXPECT_EQ(merge({one, other}, {"a", "b"}).error().kind, FailureKind::kUsage);
}

ComparedReport report_of(const Seeds& seeds, double slower_s, std::uint64_t fails_every) {
  ComparedReport out{.scenario = "pick", .controller = "pick", .fingerprint = "abc"};
  for (const std::uint64_t seed : seeds) {
    Episode one = episode(seed);
    one.as_expected = fails_every == 0 || seed % fails_every != 0;
    one.values = {{"job_s", 50 + static_cast<double>(seed % 13) + slower_s}, {"drops", 0}};
    out.episodes.push_back(one);
  }
  return out;
}

TEST(ReportDiff, FindsRegressionsOnly) {
  const auto seeds = *parse_seeds("1..60");
  const auto before = report_of(seeds, 0, 0);
  const auto same = compare(before, report_of(seeds, 0, 0), 0.05);
  EXPECT_TRUE(same.paired);
  EXPECT_FALSE(same.is_regression());
  const auto slower = compare(before, report_of(seeds, 0.5, 0), 0.05);
  EXPECT_TRUE(slower.is_regression()) << difference_table(slower);
  const auto quicker = compare(before, report_of(seeds, -0.5, 0), 0.05);
  EXPECT_FALSE(quicker.is_regression());
  EXPECT_NE(difference_table(quicker).find("better"), std::string::npos);
  EXPECT_TRUE(compare(before, report_of(seeds, 0, 4), 0.05).is_regression());
  // A single failure in sixty is no evidence.
  EXPECT_FALSE(compare(before, report_of(seeds, 0, 60), 0.05).is_regression());
}

TEST(ReportDiff, OtherSeedsAreTwoSamples) {
  const auto before = report_of(*parse_seeds("1..60"), 0, 0);
  const auto other = compare(before, report_of(*parse_seeds("101..160"), 0, 0), 0.05);
  EXPECT_FALSE(other.paired);
  EXPECT_FALSE(other.is_regression());
  EXPECT_TRUE(compare(before, report_of(*parse_seeds("101..160"), 8, 0), 0.05).is_regression());
  EXPECT_TRUE(compare(before, report_of(*parse_seeds("101..160"), 0, 3), 0.05).is_regression());
}

}  // namespace
}  // namespace aprsim::client
