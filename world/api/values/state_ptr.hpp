#pragma once

#include <memory>

namespace aprsim::world {
struct WorldState;
}

namespace aprsim::api {

/// The whole state of a world between two steps: immutable, and opaque outside of `world`.
using StatePtr = std::shared_ptr<const world::WorldState>;

}  // namespace aprsim::api
