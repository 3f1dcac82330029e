#pragma once

#include <optional>
#include <vector>

#include "aprsim/v1/web.pb.h"
#include "world/api/ports/ports.hpp"

namespace aprsim::web {

/// The commands that a viewer's request makes, to be submitted in this order. Absent for requests
/// that are no commands for the world as they stand (watch, authenticate, jog, write_register).
/// Errors name the field, value and limit.
[[nodiscard]] std::optional<Result<std::vector<decltype(api::Command::body)>>> commands_of(
    const v1::ViewerRequest& request, const api::Snapshot& snapshot);

}  // namespace aprsim::web
