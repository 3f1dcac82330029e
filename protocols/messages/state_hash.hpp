#pragma once

#include <cstdint>

#include "world/api/snapshot/snapshot.hpp"

namespace aprsim::protocols {

/// Hash (FNV-1a) of the bits of all body poses and velocities, joint positions and velocities,
/// fingers, the belt's travel, and the signals of devices. Equal states of equal scenes have equal
/// hashes.
[[nodiscard]] std::uint64_t state_hash(const api::Snapshot& snapshot);

}  // namespace aprsim::protocols
