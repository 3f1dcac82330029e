#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

namespace aprsim::trace {

/// A column of the alignment of two sequences: a pair, or a gap in one of them.
struct AlignedPair {
  std::optional<std::size_t> a, b;
};

/// Cost of leaving one out, of either sequence.
inline constexpr unsigned kGapCost = 6;
/// Never paired; any sum of two gaps is less.
inline constexpr unsigned kNeverPaired = 1U << 20U;

/// Pairs two sequences in their order at the least total cost (Needleman and Wunsch 1970), within a
/// band about the diagonal that grows until it holds the optimum (Ukkonen 1985), or memory for some
/// 10^8 places; beyond that the best within the band. `cost(i, j)`: cost of pairing a[i] with
/// b[j], 0 if they are equal.
[[nodiscard]] std::vector<AlignedPair> align(
    std::size_t size_a, std::size_t size_b,
    const std::function<unsigned(std::size_t, std::size_t)>& cost);

}  // namespace aprsim::trace
