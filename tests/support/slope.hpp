#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

namespace aprsim::test {

/// Theil-Sen slope of equidistant values: the median slope of all pairs. Single jumps and outliers
/// hardly move it; steady growth is its value. Unit: that of the values, for each value. NaN for
/// fewer than two values.
inline double median_slope(std::span<const double> values) {
  std::vector<double> slopes;
  for (std::size_t i = 0; i < values.size(); ++i) {
    for (std::size_t j = i + 1; j < values.size(); ++j) {
      slopes.push_back((values[j] - values[i]) / static_cast<double>(j - i));
    }
  }
  if (slopes.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = slopes.begin() + static_cast<std::ptrdiff_t>(slopes.size() / 2);
  std::ranges::nth_element(slopes, middle);
  return *middle;
}

}  // namespace aprsim::test
