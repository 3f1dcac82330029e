#pragma once

#include <cstddef>
#include <vector>

namespace aprsim::client {

struct Interval {
  double low = 0, high = 0;
};

/// What a sweep says of one measure.
struct Distribution {
  std::size_t count = 0;  ///< runs that have it
  double mean = 0, deviation = 0;
  Interval mean_95;  ///< confidence interval of the mean; of one value alone that value
  double min = 0, p05 = 0, median = 0, p95 = 0, max = 0;
};

/// Of at least one value. Deviation with n - 1; the interval by Student's t; shares between two
/// values by linear interpolation. The order of the values makes no difference to any bit.
[[nodiscard]] Distribution distribution_of(std::vector<double> values);

/// Confidence interval (95 %) of the probability of what happened in `hits` of `count` runs, after
/// Wilson (1927). `count` is at least 1.
[[nodiscard]] Interval share_95(std::size_t hits, std::size_t count);

}  // namespace aprsim::client
