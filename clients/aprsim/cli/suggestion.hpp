#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace aprsim::client {

/// The candidate that a mistyped or shortened word most likely means; nothing when none is near.
[[nodiscard]] std::optional<std::string> nearest(std::string_view word,
                                                 std::span<const std::string> candidates);

/// Fewest insertions, deletions, replacements and swaps of neighbours that make one word the other
/// (optimal string alignment).
[[nodiscard]] std::size_t edit_distance(std::string_view a, std::string_view b);

}  // namespace aprsim::client
