#pragma once

#include <cstddef>
#include <vector>

namespace aprsim::client {

struct Interval {
  double low = 0, high = 0;
};

/// Statistics of one measure over the runs of a batch.
struct Distribution {
  std::size_t count = 0;  ///< runs with a value
  double mean = 0, deviation = 0;
  Interval mean_95;  ///< confidence interval of the mean; the value itself for one run
  double min = 0, p05 = 0, median = 0, p95 = 0, max = 0;
};

/// Statistics of at least one value: sample standard deviation (n - 1), Student's t interval,
/// quantiles by linear interpolation. The result does not depend on the order of the values.
[[nodiscard]] Distribution distribution_of(std::vector<double> values);

/// Value below which `share` of the sorted values lies, by linear interpolation.
[[nodiscard]] double value_at(const std::vector<double>& sorted, double share);

/// 95 % confidence interval of a success rate with `hits` in `count` runs (Wilson 1927). `count`
/// is at least 1.
[[nodiscard]] Interval share_95(std::size_t hits, std::size_t count);

}  // namespace aprsim::client
