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

/// Two samples of one distribution? The greatest distance of their distribution functions, and how
/// probable one as large would be.
struct KolmogorovSmirnov {
  double d = 0, p = 1;
};
/// With Stephens's correction for small samples (Press et al. 2007, ch. 14.3.3). Neither is empty.
inline KolmogorovSmirnov kolmogorov_smirnov(std::vector<double> a, std::vector<double> b) {
  if (a.empty() || b.empty()) throw std::invalid_argument("no samples");
  std::sort(a.begin(), a.end());
  std::sort(b.begin(), b.end());
  const auto na = static_cast<double>(a.size()), nb = static_cast<double>(b.size());
  KolmogorovSmirnov out;
  for (std::size_t i = 0, k = 0; i < a.size() && k < b.size();) {
    const double value = std::min(a[i], b[k]);
    while (i < a.size() && a[i] <= value) ++i;
    while (k < b.size() && b[k] <= value) ++k;
    const double apart = static_cast<double>(i) / na - static_cast<double>(k) / nb;
    out.d = std::max(out.d, std::abs(apart));
  }
  const double root = std::sqrt(na * nb / (na + nb));
  const double lambda = (root + 0.12 + 0.11 / root) * out.d;
  if (lambda < 0.2) return out;  // the series is 1 there, and converges slowly
  double sum = 0;
  for (int j = 1; j <= 100; ++j)
    sum += (j % 2 == 1 ? 2 : -2) * std::exp(-2 * j * j * lambda * lambda);
  out.p = std::clamp(sum, 0.0, 1.0);
  return out;
}

}  // namespace aprsim::bench
