#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tests/benchmarks/support/plot.hpp"
#include "tests/benchmarks/support/statistics.hpp"

namespace aprsim::bench {

/// The upper half of a distribution, for a plot with two log axes: the fraction of samples that are
/// larger, and the value.
inline Series tails(std::string name, const std::vector<double>& samples) {
  Series series{std::move(name), {}};
  for (const double tail : {0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001, 0.0005}) {
    series.points.emplace_back(tail, percentile(samples, 1 - tail));
  }
  return series;
}

}  // namespace aprsim::bench
