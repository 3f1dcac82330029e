#pragma once

#include <cstdint>
#include <vector>

#include "world/api/snapshot/snapshot.hpp"

namespace aprsim::physics {

/// Two things that touch.
struct ContactPair {
  std::uint64_t key = 0;  ///< of both sides: pairs are in its order
  api::ContactSide first, second;

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [key, first, second] = self;
    io(key, first, second);
  }
};

/// All that touch, each pair once, by their keys.
struct ContactPairs {
  std::vector<ContactPair> all;
  std::uint64_t version = 0;  ///< another one when they may be others
};

}  // namespace aprsim::physics
