#include "clients/aprsim/batch/seeds.hpp"

#include <algorithm>
#include <charconv>
#include <string_view>

#include <fmt/format.h>

namespace aprsim::client {
namespace {

template <typename Number>
std::optional<Number> whole(std::string_view text) {
  Number value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

std::optional<std::vector<std::uint64_t>> parse_seeds(const std::string& text) {
  std::vector<std::uint64_t> out;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string_view part = std::string_view(text).substr(begin, end - begin);
    begin = end + 1;
    const std::size_t dots = part.find("..");
    const auto first = whole<std::uint64_t>(part.substr(0, dots));
    const auto last =
        dots == std::string_view::npos ? first : whole<std::uint64_t>(part.substr(dots + 2));
    if (!first || !last || *last < *first || *last - *first >= kMaxSeeds - out.size()) {
      return std::nullopt;
    }
    for (std::uint64_t seed = *first;; ++seed) {
      out.push_back(seed);
      if (seed == *last) break;
    }
  }
  std::ranges::sort(out);
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

std::string seeds_text(const std::vector<std::uint64_t>& seeds) {
  std::string out;
  for (std::size_t begin = 0; begin < seeds.size();) {
    std::size_t end = begin + 1;
    while (end < seeds.size() && seeds[end] == seeds[end - 1] + 1) ++end;
    if (!out.empty()) out += ',';
    out += end - begin == 1 ? std::to_string(seeds[begin])
                            : fmt::format("{}..{}", seeds[begin], seeds[end - 1]);
    begin = end;
  }
  return out.empty() ? "none" : out;
}

std::optional<Shard> parse_shard(const std::string& text) {
  const std::string_view all(text);
  const std::size_t slash = all.find('/');
  if (slash == std::string_view::npos) return std::nullopt;
  const auto index = whole<std::size_t>(all.substr(0, slash));
  const auto count = whole<std::size_t>(all.substr(slash + 1));
  if (!index || !count || *index >= *count) return std::nullopt;
  return Shard{*index, *count};
}

std::vector<std::uint64_t> share_of(const std::vector<std::uint64_t>& seeds, const Shard& shard) {
  std::vector<std::uint64_t> out;
  for (std::size_t i = shard.index; i < seeds.size(); i += shard.count) out.push_back(seeds[i]);
  return out;
}

}  // namespace aprsim::client
