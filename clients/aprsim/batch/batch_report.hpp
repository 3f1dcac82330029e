#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "clients/aprsim/batch/batch_directory.hpp"
#include "clients/aprsim/batch/distribution.hpp"
#include "clients/wires/outcome.hpp"

namespace aprsim::client {

/// Of episodes whose parameter lies between two values, those that ended as expected.
struct SuccessBin {
  double from = 0, to = 0;
  std::size_t runs = 0, as_expected = 0;
  Interval share_95;  ///< after Wilson
};

/// How success depends on one of the values that varied: fifths of the episodes by that value.
struct SuccessByParameter {
  std::string parameter;
  std::vector<SuccessBin> bins;
};

/// How an outcome goes with a parameter.
struct Sensitivity {
  std::string parameter, outcome;  ///< "as_expected", or a measure
  double rank_correlation = 0;     ///< Spearman's
  double p = 1, p_adjusted = 1;    ///< for the share of false findings in the table
};

struct WorstEpisode {
  std::uint64_t seed = 0;
  std::string why;
  bool journal = false;
};

/// Of episodes in the order of their seeds.
[[nodiscard]] std::vector<SuccessByParameter> success_by_parameter(const Batch& batch);
/// By rising p.
[[nodiscard]] std::vector<Sensitivity> sensitivity_of(const Batch& batch);
/// The worst first: not as expected, with the most bounds broken, the least score, the longest.
[[nodiscard]] std::vector<WorstEpisode> worst_of(const Batch& batch, std::size_t most);

inline constexpr std::size_t kWorstShown = 10;

/// The report. The same episodes give the same text, however they came about.
[[nodiscard]] nlohmann::ordered_json batch_json(const Batch& batch);
[[nodiscard]] std::string batch_table(const Batch& batch);
/// A page that needs nothing else, with plots.
[[nodiscard]] std::string batch_page(const Batch& batch);
/// report.json, report.txt and report.html, each whole or not at all.
[[nodiscard]] Outcome<void> write_report(const Batch& batch, const BatchDirectory& directory);

}  // namespace aprsim::client
