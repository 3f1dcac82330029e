#pragma once

#include "world/api/commands/command.hpp"
#include "world/api/snapshot/snapshot.hpp"
#include "world/base/result.hpp"

namespace aprsim::world {

/// Refuses what can be judged without the world's state: indices, non-finite numbers, signs.
/// Errors name the field, the value and what was expected.
[[nodiscard]] Result<void> check(const api::Command& command, const api::CellDescription& cell);

}  // namespace aprsim::world
