#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace aprsim::usage {

/// The nearest candidate of a mistyped or shortened word; absent when none is near.
[[nodiscard]] std::optional<std::string> nearest(std::string_view word,
                                                 std::span<const std::string> candidates);

/// "; did you mean 'WORD'?"; empty when no candidate is near.
[[nodiscard]] std::string suggestion(std::string_view word,
                                     std::span<const std::string> candidates);

/// Edit distance with insertions, deletions, replacements and swaps of neighbours (optimal string
/// alignment).
[[nodiscard]] std::size_t edit_distance(std::string_view a, std::string_view b);

}  // namespace aprsim::usage
