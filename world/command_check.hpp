#pragma once

#include "world/api/command.hpp"
#include "world/api/error.hpp"
#include "world/api/snapshot.hpp"

namespace aprsim::world {

/// Refuses what can be judged without the world's state: indices, non-finite numbers, signs.
/// Errors name the field, the value and what was expected.
[[nodiscard]] Result<void> check(const api::Command& command, const api::CellDescription& cell);

}  // namespace aprsim::world
