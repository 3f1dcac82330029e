#include "clients/aprsim/batch/significance.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/hypergeometric.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>

namespace aprsim::client {
namespace {

constexpr std::size_t kMostExact = 50;  // differences
constexpr double kSlack = 1e-7;         // relative tolerance of equal likelihoods

struct Ranks {
  std::vector<double> of;  ///< from 1; ties at their mean
  double ties = 0;         ///< sum of t^3 - t over groups of t equal values
};

Ranks ranks_of(std::span<const double> values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return values[i]; });
  Ranks out{.of = std::vector<double>(values.size())};
  for (std::size_t begin = 0; begin < order.size();) {
    std::size_t end = begin;
    while (end < order.size() && values[order[end]] == values[order[begin]]) ++end;
    const double rank = (static_cast<double>(begin + end) + 1) / 2;
    for (std::size_t i = begin; i < end; ++i) out.of[order[i]] = rank;
    const auto tied = static_cast<double>(end - begin);
    out.ties += tied * tied * tied - tied;
    begin = end;
  }
  return out;
}

double of_normal(double distance, double deviation) {
  if (!(deviation > 0)) return 1;
  const double z = std::max(0.0, std::abs(distance) - 0.5) / deviation;
  return std::min(1.0, 2 * boost::math::cdf(boost::math::complement(boost::math::normal(), z)));
}

/// Distribution of the sum of positive ranks under random signs; ranks in halves.
double exact_signed_rank(const std::vector<double>& ranks, double positive) {
  std::vector<int> halves;
  for (const double rank : ranks) halves.push_back(static_cast<int>(std::lround(2 * rank)));
  const int total = std::accumulate(halves.begin(), halves.end(), 0);
  std::vector<double> ways(static_cast<std::size_t>(total) + 1);
  ways[0] = 1;
  for (const int rank : halves) {
    for (int sum = total; sum >= rank; --sum) {
      ways[static_cast<std::size_t>(sum)] += ways[static_cast<std::size_t>(sum - rank)];
    }
    for (double& way : ways) way /= 2;
  }
  const auto at = static_cast<int>(std::lround(2 * positive));
  const int low = std::min(at, total - at);
  const double tail = std::accumulate(ways.begin(), ways.begin() + low + 1, 0.0);
  return std::min(1.0, 2 * tail);
}

}  // namespace

Correlation rank_correlation(std::span<const double> x, std::span<const double> y) {
  const auto n = static_cast<double>(x.size());
  if (x.size() < 4) return {};
  const Ranks a = ranks_of(x), b = ranks_of(y);
  const double mean = (n + 1) / 2;
  // Sorted by x, so that the order of the pairs does not affect the result.
  std::vector<std::pair<double, double>> pairs;
  for (std::size_t i = 0; i < x.size(); ++i) pairs.emplace_back(a.of[i] - mean, b.of[i] - mean);
  std::ranges::sort(pairs);
  double both = 0, of_a = 0, of_b = 0;
  for (const auto& [u, v] : pairs) {
    both += u * v;
    of_a += u * u;
    of_b += v * v;
  }
  if (!(of_a > 0 && of_b > 0)) return {};
  const double rho = std::clamp(both / std::sqrt(of_a * of_b), -1.0, 1.0);
  if (std::abs(rho) >= 1) return {rho, 0};
  const double t = std::abs(rho) * std::sqrt((n - 2) / (1 - rho * rho));
  const double tail = boost::math::cdf(boost::math::complement(boost::math::students_t(n - 2), t));
  return {rho, std::min(1.0, 2 * tail)};
}

double fisher_exact(std::size_t hits_a, std::size_t count_a, std::size_t hits_b,
                    std::size_t count_b) {
  const std::size_t hits = hits_a + hits_b, all = count_a + count_b;
  if (count_a == 0 || count_b == 0 || hits == 0 || hits == all) return 1;
  const boost::math::hypergeometric_distribution<double> chance(
      static_cast<unsigned>(hits), static_cast<unsigned>(count_a), static_cast<unsigned>(all));
  const double observed = boost::math::pdf(chance, static_cast<unsigned>(hits_a));
  const std::size_t least = hits > count_b ? hits - count_b : 0, most = std::min(hits, count_a);
  double p = 0;
  for (std::size_t k = least; k <= most; ++k) {
    const double here = boost::math::pdf(chance, static_cast<unsigned>(k));
    if (here <= observed * (1 + kSlack)) p += here;
  }
  return std::min(1.0, p);
}

double mcnemar_exact(std::size_t only_a, std::size_t only_b) {
  const std::size_t both = only_a + only_b;
  if (both == 0) return 1;
  const boost::math::binomial chance(static_cast<double>(both), 0.5);
  return std::min(1.0, 2 * boost::math::cdf(chance, static_cast<double>(std::min(only_a, only_b))));
}

double signed_rank(std::span<const double> differences) {
  std::vector<double> sizes, left;
  for (const double difference : differences) {
    if (difference == 0) continue;
    left.push_back(difference);
    sizes.push_back(std::abs(difference));
  }
  if (left.empty()) return 1;
  const Ranks ranks = ranks_of(sizes);
  double positive = 0;
  for (std::size_t i = 0; i < left.size(); ++i) positive += left[i] > 0 ? ranks.of[i] : 0;
  if (left.size() <= kMostExact) return exact_signed_rank(ranks.of, positive);
  const auto n = static_cast<double>(left.size());
  const double variance = n * (n + 1) * (2 * n + 1) / 24 - ranks.ties / 48;
  return of_normal(positive - n * (n + 1) / 4, std::sqrt(variance));
}

double rank_sum(std::span<const double> a, std::span<const double> b) {
  const auto n = static_cast<double>(a.size()), m = static_cast<double>(b.size());
  if (a.empty() || b.empty()) return 1;
  std::vector<double> all(a.begin(), a.end());
  all.insert(all.end(), b.begin(), b.end());
  const Ranks ranks = ranks_of(all);
  const double sum = std::accumulate(ranks.of.begin(), ranks.of.begin() + std::ssize(a), 0.0);
  const double total = n + m;
  const double variance = n * m / 12 * (total + 1 - ranks.ties / (total * (total - 1)));
  return of_normal(sum - n * (total + 1) / 2, std::sqrt(std::max(0.0, variance)));
}

namespace {

/// Indices by rising p.
std::vector<std::size_t> by_size(std::span<const double> p) {
  std::vector<std::size_t> order(p.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return p[i]; });
  return order;
}

}  // namespace

std::vector<double> by_false_discovery(std::span<const double> p) {
  const auto order = by_size(p);
  std::vector<double> out(p.size());
  double least = 1;
  for (std::size_t i = order.size(); i > 0; --i) {
    least =
        std::min(least, p[order[i - 1]] * static_cast<double>(p.size()) / static_cast<double>(i));
    out[order[i - 1]] = least;
  }
  return out;
}

std::vector<double> by_any_error(std::span<const double> p) {
  const auto order = by_size(p);
  std::vector<double> out(p.size());
  double most = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    most = std::max(most, std::min(1.0, p[order[i]] * static_cast<double>(p.size() - i)));
    out[order[i]] = most;
  }
  return out;
}

}  // namespace aprsim::client
