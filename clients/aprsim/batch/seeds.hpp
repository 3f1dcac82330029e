#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace aprsim::client {

inline constexpr std::size_t kMaxSeeds = 1'000'000;

/// Parses "1..1000", "7", "1..10,20,30..40" to rising, distinct seeds; absent for another text or
/// more than kMaxSeeds.
[[nodiscard]] std::optional<std::vector<std::uint64_t>> parse_seeds(const std::string& text);
/// Formats seeds as "1..1000"; no seeds as "none".
[[nodiscard]] std::string seeds_text(const std::vector<std::uint64_t>& seeds);

/// One of `count` shards of a list of seeds.
struct Shard {
  std::size_t index = 0;  ///< from 0
  std::size_t count = 1;
  bool operator==(const Shard&) const = default;
};
/// Parses "3/10"; absent for another text.
[[nodiscard]] std::optional<Shard> parse_shard(const std::string& text);
/// The seeds of a shard, every `count`-th one. Each seed is in exactly one shard, and shards differ
/// by one seed at most.
[[nodiscard]] std::vector<std::uint64_t> share_of(const std::vector<std::uint64_t>& seeds,
                                                  const Shard& shard);

}  // namespace aprsim::client
