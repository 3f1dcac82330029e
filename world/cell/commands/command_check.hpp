#pragma once

#include <memory>

#include "world/api/commands/command.hpp"
#include "world/api/snapshot/snapshot.hpp"
#include "world/base/result.hpp"

namespace aprsim::world {

/// Checks a command as far as possible without the world's state: indices, names, non-finite
/// numbers, signs. Keeps resolved names of faults and crossings in the command. Errors name the
/// field, the value and what was expected. Thread: any.
[[nodiscard]] Result<void> check(api::Command& command,
                                 const std::shared_ptr<const api::CellDescription>& cell);

/// Checks that a command still concerns the robot that it was meant for, in the cell as it is when
/// the command takes effect. Error: kUnavailable, the robot has left the cell.
[[nodiscard]] Result<void> check_addressee(const api::Command& command,
                                           const std::shared_ptr<const api::CellDescription>& now);

}  // namespace aprsim::world
