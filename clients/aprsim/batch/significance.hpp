#pragma once

#include <cstddef>
#include <span>
#include <vector>

/// Tests of significance. All two-sided but where said otherwise; p is 1 where nothing can be told.
/// The order of the values makes no difference to any bit, unless they are pairs.
namespace aprsim::client {

/// Spearman's rank correlation of pairs, ties at their mean rank, with p by Student's t.
struct Correlation {
  double rho = 0, p = 1;
};
/// Of as many x as y. Fewer than four pairs or values that are all the same have none (rho 0, p 1).
[[nodiscard]] Correlation rank_correlation(std::span<const double> x, std::span<const double> y);

/// Fisher's exact test of two shares: `hits` of `count` in a and in b.
[[nodiscard]] double fisher_exact(std::size_t hits_a, std::size_t count_a, std::size_t hits_b,
                                  std::size_t count_b);
/// McNemar's exact test: of pairs that differ, so many where only a hits and only b does.
[[nodiscard]] double mcnemar_exact(std::size_t only_a, std::size_t only_b);
/// Wilcoxon's signed-rank test of differences; zeros are left out. Exact up to 50 differences, else
/// by the normal distribution with corrections for ties and continuity.
[[nodiscard]] double signed_rank(std::span<const double> differences);
/// Mann and Whitney's rank-sum test, by the normal distribution with corrections for ties and
/// continuity.
[[nodiscard]] double rank_sum(std::span<const double> a, std::span<const double> b);

/// Adjusted p: for the share of false findings among what is found (Benjamini and Hochberg 1995).
[[nodiscard]] std::vector<double> by_false_discovery(std::span<const double> p);
/// Adjusted p: for any false finding at all (Holm 1979).
[[nodiscard]] std::vector<double> by_any_error(std::span<const double> p);

}  // namespace aprsim::client
