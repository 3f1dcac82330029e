#pragma once

#include <cstddef>
#include <span>
#include <vector>

/// Significance tests, two-sided unless stated otherwise; p is 1 where a test is undefined. The
/// result does not depend on the order of unpaired values.
namespace aprsim::client {

/// Spearman's rank correlation of pairs, ties at their mean rank, with p by Student's t.
struct Correlation {
  double rho = 0, p = 1;
};
/// Spearman's correlation of equally many x and y. Fewer than four pairs or constant values have
/// rho 0 and p 1.
[[nodiscard]] Correlation rank_correlation(std::span<const double> x, std::span<const double> y);

/// Fisher's exact test of two shares: `hits` of `count` in a and in b.
[[nodiscard]] double fisher_exact(std::size_t hits_a, std::size_t count_a, std::size_t hits_b,
                                  std::size_t count_b);
/// McNemar's exact test, from the numbers of pairs in which only a or only b succeeds.
[[nodiscard]] double mcnemar_exact(std::size_t only_a, std::size_t only_b);
/// Wilcoxon's signed-rank test of differences; zeros are left out. Exact up to 50 differences, else
/// by the normal distribution with corrections for ties and continuity.
[[nodiscard]] double signed_rank(std::span<const double> differences);
/// Mann and Whitney's rank-sum test, by the normal distribution with corrections for ties and
/// continuity.
[[nodiscard]] double rank_sum(std::span<const double> a, std::span<const double> b);

/// Adjusted p that controls the false discovery rate (Benjamini and Hochberg 1995).
[[nodiscard]] std::vector<double> by_false_discovery(std::span<const double> p);
/// Adjusted p that controls the family-wise error rate (Holm 1979).
[[nodiscard]] std::vector<double> by_any_error(std::span<const double> p);

}  // namespace aprsim::client
