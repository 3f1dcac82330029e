#pragma once

#include <cstdint>
#include <vector>

#include "world/api/snapshot/snapshot.hpp"

namespace aprsim::physics {

/// Two sides in contact.
struct ContactPair {
  std::uint64_t key = 0;  ///< encodes both sides; pairs are sorted by it
  api::ContactSide first, second;

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [key, first, second] = self;
    io(key, first, second);
  }
};

/// All pairs in contact, each once, sorted by key.
struct ContactPairs {
  std::vector<ContactPair> all;
  std::uint64_t version = 0;  ///< changes whenever the pairs may have changed
};

}  // namespace aprsim::physics
