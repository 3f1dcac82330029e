#include "clients/aprsim/batch/report_diff.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/batch/distribution.hpp"
#include "clients/aprsim/batch/significance.hpp"
#include "clients/aprsim/scenario/measure_text.hpp"
#include "world/scenario/measure_kinds.hpp"

namespace aprsim::client {
namespace {

constexpr std::size_t kLeastPairs = 2;

const char* word_of(Change change) {
  switch (change) {
    case Change::kNone:
      return "";
    case Change::kBetter:
      return "better";
    case Change::kWorse:
      return "worse";
    case Change::kOther:
      return "different";
  }
  return "";
}

/// Values of a measure in both reports, and the differences of pairs.
struct Values {
  std::vector<double> before, after, differences;
};

Values values_of(const std::string& measure, const ComparedReport& before,
                 const ComparedReport& after) {
  Values out;
  std::map<std::uint64_t, double> known;
  for (const Episode& episode : before.episodes) {
    const auto value = episode.values.find(measure);
    if (value == episode.values.end()) continue;
    out.before.push_back(value->second);
    known[episode.seed] = value->second;
  }
  for (const Episode& episode : after.episodes) {
    const auto value = episode.values.find(measure);
    if (value == episode.values.end()) continue;
    out.after.push_back(value->second);
    const auto partner = known.find(episode.seed);
    if (partner != known.end()) out.differences.push_back(value->second - partner->second);
  }
  return out;
}

OutcomeDifference difference_of_success(const ComparedReport& before, const ComparedReport& after,
                                        bool paired) {
  const auto hits = [](const ComparedReport& report) {
    return static_cast<std::size_t>(
        std::ranges::count_if(report.episodes, [](const Episode& e) { return e.as_expected; }));
  };
  const auto share = [&](const ComparedReport& report) {
    return static_cast<double>(hits(report)) / static_cast<double>(report.episodes.size());
  };
  OutcomeDifference out{.outcome = kAsExpected, .before = share(before), .after = share(after)};
  if (!paired) {
    out.p = fisher_exact(hits(before), before.episodes.size(), hits(after), after.episodes.size());
    return out;
  }
  std::map<std::uint64_t, bool> known;
  for (const Episode& episode : before.episodes) known[episode.seed] = episode.as_expected;
  std::size_t only_before = 0, only_after = 0;
  for (const Episode& episode : after.episodes) {
    const auto partner = known.find(episode.seed);
    if (partner == known.end() || partner->second == episode.as_expected) continue;
    ++(partner->second ? only_before : only_after);
  }
  out.p = mcnemar_exact(only_before, only_after);
  return out;
}

std::size_t pairs_of(const ComparedReport& before, const ComparedReport& after) {
  std::set<std::uint64_t> seeds;
  for (const Episode& episode : before.episodes) seeds.insert(episode.seed);
  return static_cast<std::size_t>(std::ranges::count_if(
      after.episodes, [&](const Episode& episode) { return seeds.contains(episode.seed); }));
}

}  // namespace

Outcome<ComparedReport> read_report(const std::string& path) {
  std::error_code status;
  const auto file = std::filesystem::is_directory(path, status)
                        ? (std::filesystem::path(path) / "report.json").string()
                        : path;
  std::ifstream in(file, std::ios::binary);
  if (!in) return failed(FailureKind::kUsage, "cannot read " + file);
  const auto json = nlohmann::json::parse(in, nullptr, /*allow_exceptions=*/false);
  const auto episodes = json.is_object() ? json.find("episodes") : json.end();
  if (!json.is_object() || episodes == json.end() || !episodes->is_array()) {
    return failed(FailureKind::kUsage, file + " is not a batch report");
  }
  ComparedReport out{.scenario = json.value("scenario", ""),
                     .controller = json.value("controller", ""),
                     .fingerprint = json.value("fingerprint", "")};
  for (const auto& one : *episodes) {
    auto episode = episode_of(one);
    if (!episode) return failed(FailureKind::kUsage, file + ": " + episode.error().message);
    out.episodes.push_back(std::move(*episode));
  }
  if (out.episodes.empty()) return failed(FailureKind::kUsage, file + " has no runs");
  return out;
}

bool ReportDifference::is_regression() const {
  return std::ranges::find(outcomes, Change::kWorse, &OutcomeDifference::change) != outcomes.end();
}

ReportDifference compare(const ComparedReport& before, const ComparedReport& after, double alpha) {
  ReportDifference out{
      .before = before.episodes.size(), .after = after.episodes.size(), .alpha = alpha};
  out.pairs = before.fingerprint == after.fingerprint ? pairs_of(before, after) : 0;
  // A paired test ignores runs without a partner, so nearly all must have one.
  out.paired = out.pairs >= kLeastPairs && 10 * out.pairs >= 9 * std::max(out.before, out.after);
  out.outcomes.push_back(difference_of_success(before, after, out.paired));
  for (const auto& kind : scenario::measure_kinds()) {
    const std::string measure(kind.name);
    const Values values = values_of(measure, before, after);
    if (values.before.empty() || values.after.empty()) continue;
    OutcomeDifference one{.outcome = measure,
                          .before = distribution_of(values.before).mean,
                          .after = distribution_of(values.after).mean};
    one.p = out.paired ? signed_rank(values.differences) : rank_sum(values.before, values.after);
    out.outcomes.push_back(std::move(one));
  }
  std::vector<double> p;
  for (const OutcomeDifference& one : out.outcomes) p.push_back(one.p);
  const auto adjusted = by_any_error(p);
  for (std::size_t i = 0; i < p.size(); ++i) {
    OutcomeDifference& one = out.outcomes[i];
    one.p_adjusted = adjusted[i];
    if (one.p_adjusted >= alpha) continue;
    const double side = better_side(one.outcome) * (one.after - one.before);
    one.change = side > 0 ? Change::kBetter : side < 0 ? Change::kWorse : Change::kOther;
  }
  return out;
}

std::string difference_table(const ReportDifference& difference) {
  std::string out =
      fmt::format("{} runs before, {} after, {}\n\n{:<28} {:>6} {:>12} {:>12} {:>10} {:>10}\n",
                  difference.before, difference.after,
                  difference.paired ? fmt::format("{} pairs of equal seeds", difference.pairs)
                                    : std::string("compared as two samples"),
                  "outcome", "better", "before", "after", "p", "adjusted p");
  for (const OutcomeDifference& one : difference.outcomes) {
    out += fmt::format("{:<28} {:>6} {:>12.5g} {:>12.5g} {:>10.2g} {:>10.2g}  {}\n",
                       measure_title(one.outcome), better_text(one.outcome), one.before, one.after,
                       one.p, one.p_adjusted, word_of(one.change));
  }
  return out +
         fmt::format("\n{} at a significance level of {:g}, adjusted for all outcomes (Holm)\n",
                     difference.is_regression() ? "worse" : "not worse", difference.alpha);
}

nlohmann::ordered_json difference_json(const ReportDifference& difference) {
  auto outcomes = nlohmann::ordered_json::array();
  for (const OutcomeDifference& one : difference.outcomes) {
    outcomes.push_back({{"outcome", one.outcome},
                        {"before", one.before},
                        {"after", one.after},
                        {"p", one.p},
                        {"p_adjusted", one.p_adjusted},
                        {"change", word_of(one.change)}});
  }
  return {{"runs_before", difference.before},
          {"runs_after", difference.after},
          {"paired", difference.paired},
          {"pairs", difference.pairs},
          {"level", difference.alpha},
          {"worse", difference.is_regression()},
          {"outcomes", outcomes}};
}

}  // namespace aprsim::client
