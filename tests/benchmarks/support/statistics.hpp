#pragma once

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

namespace aprsim::bench {

/// The smallest sample that at least the fraction `p` of all does not exceed.
inline double percentile(std::vector<double> samples, double p) {
  if (samples.empty()) throw std::invalid_argument("no samples");
  const auto rank = static_cast<std::size_t>(
      std::max(0.0, std::ceil(p * static_cast<double>(samples.size())) - 1));
  const auto nth =
      samples.begin() + static_cast<std::ptrdiff_t>(std::min(rank, samples.size() - 1));
  std::nth_element(samples.begin(), nth, samples.end());
  return *nth;
}

inline double median(std::vector<double> samples) { return percentile(std::move(samples), 0.5); }

inline double mean(const std::vector<double>& samples) {
  if (samples.empty()) throw std::invalid_argument("no samples");
  double sum = 0;
  for (const double sample : samples) sum += sample;
  return sum / static_cast<double>(samples.size());
}

}  // namespace aprsim::bench
