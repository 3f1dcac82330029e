#pragma once

#include <cstddef>
#include <vector>

namespace aprsim::bench {

/// Numbers that tell how one run ended; of all runs that are compared the same numbers.
using Measures = std::vector<double>;

/// Whether two samples of runs are of one distribution.
struct TwoSamples {
  std::vector<double>
      distances;            ///< by measure, of the distribution functions (Kolmogorov, Smirnov)
  std::size_t measure = 0;  ///< that of the greatest one
  double distance = 0;      ///< the greatest one
  double p = 1;             ///< how probable one as great is, of any measure, by chance alone
};

/// A permutation test (Fisher; Phipson and Smyth 2010 for p) of the greatest distance over all
/// measures: exact for samples of any size, for ties, and however the measures hang together
/// (Westfall and Young 1993), as long as the runs are independent. At least 1 / (permutations + 1).
/// Throws std::invalid_argument for an empty sample or runs of different numbers of measures.
[[nodiscard]] TwoSamples compare(const std::vector<Measures>& a, const std::vector<Measures>& b,
                                 unsigned permutations = 9999, unsigned seed = 1);

}  // namespace aprsim::bench
