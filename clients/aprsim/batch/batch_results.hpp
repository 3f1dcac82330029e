#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "clients/aprsim/batch/batch_directory.hpp"
#include "clients/aprsim/batch/distribution.hpp"

namespace aprsim::client {

/// Runs whose parameter lies between two values.
struct SuccessBin {
  double from = 0, to = 0;
  std::size_t runs = 0, as_expected = 0;
  Interval share_95;  ///< confidence interval of the success rate (Wilson)
};

/// Success rate by one varied parameter: fifths of the runs by its value.
struct SuccessByParameter {
  std::string parameter;
  std::vector<SuccessBin> bins;
};

/// Correlation of an outcome with a varied parameter.
struct Sensitivity {
  std::string parameter, outcome;  ///< "as_expected", or a measure
  double rank_correlation = 0;     ///< Spearman's
  double p = 1, p_adjusted = 1;    ///< adjusted for the table's false discovery rate
};

/// A run that failed or deviates from the others.
struct WorstRun {
  std::uint64_t seed = 0;
  std::string why;
  bool journal = false;
};

/// Empty when all runs, or none, ended as expected: then no parameter makes a difference.
[[nodiscard]] std::vector<SuccessByParameter> success_by_parameter(const Batch& batch);
/// Sorted by rising p.
[[nodiscard]] std::vector<Sensitivity> sensitivity_of(const Batch& batch);
/// The runs that failed, then those with a measure far worse than the other runs', worst first. A
/// measure is far worse when it lies beyond the outer fence of Tukey (1977): the quartile and
/// three times the distance of the quartiles.
[[nodiscard]] std::vector<WorstRun> worst_runs(const Batch& batch, std::size_t most);
/// The first `most` seeds of all runs, worst first: not as expected, with the most bounds broken,
/// with the lowest score, the longest.
[[nodiscard]] std::vector<std::uint64_t> worst_seeds(const Batch& batch, std::size_t most);

/// Values of an outcome ("as_expected" = 1 or 0) of all runs that have it, by seed.
[[nodiscard]] std::vector<double> values_of(const Batch& batch, const std::string& outcome);

}  // namespace aprsim::client
