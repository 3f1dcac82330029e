#pragma once

#include <cstdint>

#include "world/api/snapshot/snapshot.hpp"

namespace aprsim::protocols {

/// Of the bits of every body's pose and velocity, every joint's position and velocity, the fingers
/// and the belt's travel (FNV-1a). Equal states of equal scenes have equal hashes.
[[nodiscard]] std::uint64_t state_hash(const api::Snapshot& snapshot);

}  // namespace aprsim::protocols
