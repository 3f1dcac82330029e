#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace aprsim::client {

inline constexpr std::size_t kMaxSeeds = 1'000'000;

/// "1..1000", "7", "1..10,20,30..40": rising, each once; nothing when the text says something else,
/// or more than kMaxSeeds.
[[nodiscard]] std::optional<std::vector<std::uint64_t>> parse_seeds(const std::string& text);
/// The same the other way round: "1..1000"; empty = "none".
[[nodiscard]] std::string seeds_text(const std::vector<std::uint64_t>& seeds);

/// Of seeds that are divided among `count` tasks the share of one.
struct Shard {
  std::size_t index = 0;  ///< from 0
  std::size_t count = 1;
  bool operator==(const Shard&) const = default;
};
/// "3/10"; nothing when the text says something else.
[[nodiscard]] std::optional<Shard> parse_shard(const std::string& text);
/// Every `count`-th one: each seed is in exactly one shard, and shards differ by one seed at most.
[[nodiscard]] std::vector<std::uint64_t> share_of(const std::vector<std::uint64_t>& seeds,
                                                  const Shard& shard);

}  // namespace aprsim::client
