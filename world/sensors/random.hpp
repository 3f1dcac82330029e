#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace aprsim::sensors {

/// SplitMix64: a few bytes of state, good enough for sensor noise, and the same numbers on every
/// platform. Seeds that are near each other give unrelated sequences.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  std::uint64_t next() {
    state_ += 0x9e3779b97f4a7c15ULL;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
  }

  /// In [0, 1).
  double uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; }

  /// One of 0 .. count - 1.
  std::uint64_t below(std::uint64_t count) {
    return std::min(static_cast<std::uint64_t>(uniform() * static_cast<double>(count)), count - 1);
  }

  /// Standard normal, clipped at `limit` standard deviations (Box-Muller).
  double gaussian(double limit) {
    const double radius = std::sqrt(-2 * std::log(1 - uniform()));
    const double value = radius * std::cos(2 * std::numbers::pi * uniform());
    return std::clamp(value, -limit, limit);
  }

 private:
  std::uint64_t state_;
};

/// Mixes the parts of a seed.
inline std::uint64_t mix_seed(std::uint64_t a, std::uint64_t b) { return Random(a).next() ^ b; }

}  // namespace aprsim::sensors
