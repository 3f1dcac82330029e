#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

namespace aprsim::robot {

/// Bytes of what copies of a value share, by address: each part counts once, however many have it.
using SharedParts = std::map<const void*, std::size_t>;

/// All of them.
[[nodiscard]] inline std::uint64_t bytes_of(const SharedParts& parts) {
  std::uint64_t sum = 0;
  for (const auto& [part, bytes] : parts) sum += bytes;
  return sum;
}

/// Bytes that a vector holds.
template <typename T>
[[nodiscard]] std::size_t bytes_of(const std::vector<T>& values) {
  return values.capacity() * sizeof(T);
}

}  // namespace aprsim::robot
