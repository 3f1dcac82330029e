#include "clients/aprsim/batch/batch_results.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <tuple>

#include <fmt/format.h>

#include "clients/aprsim/batch/significance.hpp"
#include "clients/aprsim/scenario/measure_text.hpp"

namespace aprsim::client {
namespace {

constexpr std::size_t kBins = 5;
constexpr std::size_t kLeastForBins = 10, kLeastForSensitivity = 10;  // runs
constexpr std::size_t kLeastForFences = 10;                           // runs
constexpr double kOuterFence = 3;                                     // distances of the quartiles
constexpr double kLeastBeyond = 0.05;  // of the median: the smallest deviation to report
constexpr std::size_t kNamedDeviations = 3;

/// The values of each parameter, rising, with their runs.
std::map<std::string, std::vector<std::pair<double, const Episode*>>> by_parameter(
    const Batch& batch) {
  std::map<std::string, std::vector<std::pair<double, const Episode*>>> out;
  for (const auto& [seed, episode] : batch.episodes) {
    for (const auto& [parameter, value] : episode.drawn) {
      out[parameter].emplace_back(value, &episode);
    }
  }
  for (auto& [parameter, pairs] : out) {
    std::ranges::stable_sort(pairs, {}, [](const auto& pair) { return pair.first; });
  }
  return out;
}

/// The outcomes that judge a run: success, the measures with a better side, and the duration.
std::set<std::string> outcomes_of(const Batch& batch) {
  std::set<std::string> out{kAsExpected};
  for (const auto& [seed, episode] : batch.episodes) {
    for (const auto& [measure, value] : episode.values) {
      if (measure == "run_s" || better_side(measure) != 0) out.insert(measure);
    }
  }
  return out;
}

std::optional<double> outcome_of(const Episode& episode, const std::string& outcome) {
  if (outcome == kAsExpected) return episode.as_expected ? 1 : 0;
  const auto found = episode.values.find(outcome);
  return found == episode.values.end() ? std::nullopt : std::optional(found->second);
}

double value_or(const Episode& episode, const char* measure, double other) {
  const auto found = episode.values.find(measure);
  return found == episode.values.end() ? other : found->second;
}

/// A measure's limit on its worse side.
struct Fence {
  double limit = 0, median = 0;
  bool above = false;  ///< worse is above the limit
};

/// Fences by measure. For run_s lower counts as better.
std::map<std::string, Fence> fences_of(const Batch& batch) {
  std::map<std::string, Fence> out;
  for (const std::string& outcome : outcomes_of(batch)) {
    if (outcome == kAsExpected) continue;
    auto values = values_of(batch, outcome);
    if (values.size() < kLeastForFences) continue;
    std::ranges::sort(values);
    const double low = value_at(values, 0.25), median = value_at(values, 0.5),
                 high = value_at(values, 0.75);
    const double reach = std::max(kOuterFence * (high - low), kLeastBeyond * std::abs(median));
    const bool above = better_side(outcome) <= 0;
    out.emplace(outcome, Fence{above ? high + reach : low - reach, median, above});
  }
  return out;
}

/// "drops 1 (median 0)" for each measure beyond its fence.
std::vector<std::string> deviations_of(const Episode& episode,
                                       const std::map<std::string, Fence>& fences) {
  std::vector<std::string> out;
  for (const auto& [measure, fence] : fences) {
    const auto found = episode.values.find(measure);
    if (found == episode.values.end()) continue;
    const double value = found->second;
    if (fence.above ? value <= fence.limit : value >= fence.limit) continue;
    out.push_back(fmt::format("{} (median {})", measure_value(measure, value),
                              measure_value_alone(measure, fence.median)));
  }
  return out;
}

std::string why_of(const Episode& episode, const std::vector<std::string>& deviations) {
  std::string out;
  const auto add = [&](const std::string& text) { out += (out.empty() ? "" : "; ") + text; };
  if (episode.as_expected) add("as expected");
  for (const std::string& bound : episode.broken) add(bound);
  if (!episode.as_expected) {
    add(episode.end_reason);
    return out;
  }
  for (std::size_t i = 0; i < std::min(deviations.size(), kNamedDeviations); ++i) {
    add(deviations[i]);
  }
  if (deviations.size() > kNamedDeviations) {
    add(fmt::format("and {} more", deviations.size() - kNamedDeviations));
  }
  return out;
}

/// All runs, the worst first.
std::vector<const Episode*> from_the_worst(const Batch& batch) {
  std::vector<const Episode*> out;
  for (const auto& [seed, episode] : batch.episodes) out.push_back(&episode);
  std::ranges::stable_sort(out, {}, [](const Episode* episode) {
    return std::tuple(episode->as_expected, -static_cast<double>(episode->broken.size()),
                      value_or(*episode, "score_share", 0), -value_or(*episode, "run_s", 0));
  });
  return out;
}

}  // namespace

std::vector<double> values_of(const Batch& batch, const std::string& outcome) {
  std::vector<double> out;
  for (const auto& [seed, episode] : batch.episodes) {
    if (const auto value = outcome_of(episode, outcome)) out.push_back(*value);
  }
  return out;
}

std::vector<SuccessByParameter> success_by_parameter(const Batch& batch) {
  std::vector<SuccessByParameter> out;
  const auto successes = values_of(batch, kAsExpected);
  if (successes.empty() || std::ranges::min(successes) == std::ranges::max(successes)) return out;
  for (const auto& [parameter, pairs] : by_parameter(batch)) {
    if (pairs.size() < kLeastForBins) continue;
    SuccessByParameter one{.parameter = parameter};
    for (std::size_t i = 0; i < kBins; ++i) {
      const std::size_t begin = pairs.size() * i / kBins, end = pairs.size() * (i + 1) / kBins;
      SuccessBin bin{.from = pairs[begin].first, .to = pairs[end - 1].first, .runs = end - begin};
      for (std::size_t k = begin; k < end; ++k) bin.as_expected += pairs[k].second->as_expected;
      bin.share_95 = share_95(bin.as_expected, bin.runs);
      one.bins.push_back(bin);
    }
    out.push_back(std::move(one));
  }
  return out;
}

std::vector<Sensitivity> sensitivity_of(const Batch& batch) {
  std::vector<Sensitivity> out;
  const auto outcomes = outcomes_of(batch);
  for (const auto& [parameter, pairs] : by_parameter(batch)) {
    for (const std::string& outcome : outcomes) {
      std::vector<double> x, y;
      for (const auto& [value, episode] : pairs) {
        if (const auto result = outcome_of(*episode, outcome)) {
          x.push_back(value);
          y.push_back(*result);
        }
      }
      if (x.size() < kLeastForSensitivity || std::ranges::min(y) == std::ranges::max(y)) continue;
      const Correlation correlation = rank_correlation(x, y);
      out.push_back({parameter, outcome, correlation.rho, correlation.p});
    }
  }
  std::vector<double> p;
  for (const Sensitivity& s : out) p.push_back(s.p);
  const auto adjusted = by_false_discovery(p);
  for (std::size_t i = 0; i < out.size(); ++i) out[i].p_adjusted = adjusted[i];
  std::ranges::stable_sort(out, {}, &Sensitivity::p);
  return out;
}

std::vector<std::uint64_t> worst_seeds(const Batch& batch, std::size_t most) {
  std::vector<std::uint64_t> out;
  for (const Episode* episode : from_the_worst(batch)) {
    if (out.size() == most) break;
    out.push_back(episode->seed);
  }
  return out;
}

std::vector<WorstRun> worst_runs(const Batch& batch, std::size_t most) {
  const auto fences = fences_of(batch);
  std::vector<std::pair<const Episode*, std::vector<std::string>>> all;
  for (const Episode* episode : from_the_worst(batch)) {
    auto deviations = deviations_of(*episode, fences);
    if (!episode->as_expected || !deviations.empty()) {
      all.emplace_back(episode, std::move(deviations));
    }
  }
  std::ranges::stable_sort(all, {}, [](const auto& one) {
    return std::pair(one.first->as_expected,
                     one.first->as_expected ? -static_cast<double>(one.second.size()) : 0.0);
  });
  all.resize(std::min(all.size(), most));
  std::vector<WorstRun> out;
  for (const auto& [episode, deviations] : all) {
    out.push_back({.seed = episode->seed,
                   .why = why_of(*episode, deviations),
                   .journal = std::ranges::binary_search(batch.journals, episode->seed)});
  }
  return out;
}

}  // namespace aprsim::client
