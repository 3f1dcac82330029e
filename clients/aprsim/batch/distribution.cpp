#include "clients/aprsim/batch/distribution.hpp"

#include <algorithm>
#include <cmath>

#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>

namespace aprsim::client {
namespace {

constexpr double kUpperTail = 0.975;  // of a two-sided interval of 95 %

}  // namespace

double value_at(const std::vector<double>& sorted, double share) {
  const double at = share * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (at - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

Distribution distribution_of(std::vector<double> values) {
  std::ranges::sort(values);
  const auto n = static_cast<double>(values.size());
  Distribution out{.count = values.size()};
  // Relative to the least value, so that equal values have an exact mean and no deviation.
  double beyond = 0;
  for (const double value : values) beyond += value - values.front();
  out.mean = values.front() + beyond / n;
  double squares = 0;
  for (const double value : values) squares += (value - out.mean) * (value - out.mean);
  double reach = 0;
  if (values.size() > 1) {
    out.deviation = std::sqrt(squares / (n - 1));
    reach = boost::math::quantile(boost::math::students_t(n - 1), kUpperTail) * out.deviation /
            std::sqrt(n);
  }
  out.mean_95 = {out.mean - reach, out.mean + reach};
  out.min = values.front();
  out.p05 = value_at(values, 0.05);
  out.median = value_at(values, 0.5);
  out.p95 = value_at(values, 0.95);
  out.max = values.back();
  return out;
}

Interval share_95(std::size_t hits, std::size_t count) {
  const double z = boost::math::quantile(boost::math::normal(), kUpperTail);
  const auto n = static_cast<double>(count);
  const double p = static_cast<double>(hits) / n;
  const double middle = (p + z * z / (2 * n)) / (1 + z * z / n);
  const double reach = z / (1 + z * z / n) * std::sqrt(p * (1 - p) / n + z * z / (4 * n * n));
  return {std::max(0.0, middle - reach), std::min(1.0, middle + reach)};
}

}  // namespace aprsim::client
